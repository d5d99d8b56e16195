"""Real spherical harmonics: orthonormal, without the Condon-Shortley sign, in the order (0,0), (1,-1), (1,0), ...

Polar axis +y, azimuth from -z towards +x. Y_l,m of m > 0 goes with cos(m azimuth), that of m < 0 with sin(|m| azimuth).
Both are polynomials in the direction, so that they are smooth at the poles too.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import factorial, pi, sqrt
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.polynomial import Polynomial

from ...numerics._vector import Vec3


def count_of(degree: int) -> int:
    """How many there are up to a degree."""
    return (degree + 1) ** 2


def degree_of(count: int) -> int:
    """The degree up to which so many are all."""
    return round(sqrt(count)) - 1


def orders(degree: int) -> Iterator[tuple[int, int]]:
    """(l, m) in their order."""
    return ((band, m) for band in range(degree + 1) for m in range(-band, band + 1))


def norm(band: int, m: int) -> float:
    """The factor of P_l^|m| cos or sin that makes the square of the harmonic integrate to 1."""
    m = abs(m)
    return sqrt((2 if m else 1) * (2 * band + 1) / (4 * pi) * factorial(band - m) / factorial(band + m))


def legendre(height: Any, degree: int) -> dict[tuple[int, int], Any]:
    """P_l^m(y) / (1 - y^2)^(m/2) for 0 <= m <= l <= degree, by (l, m): polynomials in the height y."""
    one = height * 0 + 1
    found = {}
    for m in range(degree + 1):
        found[m, m] = one if m == 0 else (2 * m - 1) * found[m - 1, m - 1]
        if m < degree:
            found[m + 1, m] = (2 * m + 1) * height * found[m, m]
        for band in range(m + 2, degree + 1):
            found[band, m] = ((2 * band - 1) * height * found[band - 1, m] - (band + m - 1) * found[band - 2, m]) / (
                band - m
            )
    return found


def harmonics(direction: Vec3, degree: int) -> list[Float[Array, "*n"]]:
    """All of them up to a degree along unit directions, in their order."""
    heights = legendre(direction.y, degree)
    # The real and the imaginary part of (sin(polar angle) e^(i azimuth))^m.
    real, imaginary = [jnp.ones_like(direction.y)], [jnp.zeros_like(direction.y)]
    for _ in range(degree):
        a, b = real[-1], imaginary[-1]
        real.append(-direction.z * a - direction.x * b)
        imaginary.append(direction.x * a - direction.z * b)
    return [
        norm(band, m) * heights[band, abs(m)] * (real[m] if m >= 0 else imaginary[-m]) for band, m in orders(degree)
    ]


def lobe_shares(exponent, degree: int) -> list:
    """What is left of the harmonics of each degree in the mean of what lies around a direction R, weighted by cos^n.

    The zonal coefficients of (n + 1) / (2 pi) max(R.w, 0)^n: Lambda_l = (n + 1) integral_0^1 t^n P_l(t) dt, so
    Lambda_0 = 1, Lambda_1 = (n + 1) / (n + 2), Lambda_l = Lambda_(l-2) (n + 2 - l) / (n + l + 1). Of n = 1 they are
    A_l / pi of Ramamoorthi and Hanrahan 2001, An efficient representation for irradiance environment maps: 1, 2/3, 1/4,
    0, -1/24. `exponent`: n >= 0, a number or an array; differentiable.
    """
    shares = [exponent * 0 + 1, (exponent + 1) / (exponent + 2)]
    for band in range(2, degree + 1):
        shares.append(shares[band - 2] * (exponent + 2 - band) / (exponent + band + 1))
    return shares[: degree + 1]


def summed(coefficients: Float[Array, "count 3"], direction: Vec3, shares: Sequence[float] | None = None) -> Vec3:
    """The sum of coefficient times harmonic along unit directions, those of degree l times `shares[l]`.

    For each m the heights are one polynomial in y, so that what is compiled does not grow with their number.
    """
    degree = degree_of(coefficients.shape[0])
    table = _in_powers(degree)
    if shares is not None:
        table = table * np.asarray([shares[band] for band, _ in orders(degree)])[:, None, None, None]
    polynomials = jnp.einsum("nmsp,nk->mspk", jnp.asarray(table, coefficients.dtype), coefficients)

    def add(carry, polynomial):
        real, imaginary, total = carry
        height = [Vec3(*(jnp.zeros_like(real) for _ in range(3))) for _ in range(2)]
        for power in reversed(range(degree + 1)):
            height = [
                Vec3(*(channel * direction.y + polynomial[side, power, k] for k, channel in enumerate((h.x, h.y, h.z))))
                for side, h in enumerate(height)
            ]
        total = total + height[0] * real + height[1] * imaginary
        turned = -direction.z * real - direction.x * imaginary, direction.x * real - direction.z * imaginary
        return (*turned, total), None

    none = jnp.zeros_like(direction.y)
    return jax.lax.scan(add, (jnp.ones_like(none), none, Vec3(none, none, none)), polynomials)[0][2]


def summed_with(coefficients: Float[Array, "count 3"], direction: Vec3, shares: Sequence[Float[Array, "*n"]]) -> Vec3:
    """The same with shares that each direction has for itself; what is compiled grows with the number of harmonics."""
    degree = degree_of(coefficients.shape[0])
    none = jnp.zeros_like(direction.y)
    total = Vec3(none, none, none)
    for number, ((band, _), along) in enumerate(zip(orders(degree), harmonics(direction, degree), strict=True)):
        term = along * shares[band]
        total = total + Vec3(*(coefficients[number, k] * term for k in range(3)))
    return total


@lru_cache(maxsize=8)
def _in_powers(degree: int) -> np.ndarray:
    """The heights of each harmonic in powers of y: (count, |m|, 2, power), where 2 is its cosine or its sine."""
    found = np.zeros((count_of(degree), degree + 1, 2, degree + 1))
    heights = legendre(Polynomial([0.0, 1.0]), degree)
    for number, (band, m) in enumerate(orders(degree)):
        powers = heights[band, abs(m)].coef * norm(band, m)
        found[number, abs(m), int(m < 0), : len(powers)] = powers
    return found
