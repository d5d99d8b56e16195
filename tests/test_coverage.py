"""Means over a pixel of what an edge cuts: against counting on a fine grid, and their derivatives against
differences.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from diffwhitted.numerics._coverage import Linear, coverage, is_cut, joint_coverage, ramp
from diffwhitted.scene.textures._square_wave import cell_mean, checker_mean, may_vary

FINE = 1001
U, V = np.meshgrid((np.arange(FINE) + 0.5) / FINE - 0.5, (np.arange(FINE) + 0.5) / FINE - 0.5)
SLOPES = [(1.0, 0.3), (-0.2, 0.9), (0.5, -0.5), (0.05, 2.0), (3.0, -0.1)]
PLACES = [-0.9, -0.4, -0.1, 0.0, 0.13, 0.45, 1.2]


def linear(value, across, down):
    return Linear(*(jnp.asarray([x], jnp.float64) for x in (value, across, down)))


def on_grid(g):
    return float(g.value[0]) + float(g.across[0]) * U + float(g.down[0]) * V


@pytest.mark.parametrize("value", PLACES)
@pytest.mark.parametrize("slopes", SLOPES)
def test_coverage_and_ramp_are_means_over_the_square(value, slopes):
    g = linear(value, *slopes)
    there = on_grid(g)
    assert coverage(g)[0] == pytest.approx(np.mean(there > 0), abs=2e-3)
    assert ramp(g)[0] == pytest.approx(np.mean(np.maximum(there, 0)), abs=1e-3)


@pytest.mark.parametrize("mean", [coverage, ramp])
@pytest.mark.parametrize("value", [-0.4, 0.0, 0.13])
@pytest.mark.parametrize("slopes", SLOPES)
def test_derivatives_of_the_means(mean, value, slopes):
    """In the value and in both slopes; at value 0 too, where |g| has none."""
    point, step = jnp.asarray([value, *slopes], jnp.float64), 1e-6

    def fn(p):
        return mean(Linear(p[0], p[1], p[2]))

    differences = [(fn(point + step * e) - fn(point - step * e)) / (2 * step) for e in jnp.eye(3)]
    np.testing.assert_allclose(
        jax.jacfwd(fn)(point), differences, atol=5e-6
    )  # a step across the kink at 0 is off by so much
    np.testing.assert_allclose(
        jax.grad(fn)(point), differences, atol=5e-6
    )  # a step across the kink at 0 is off by so much


@pytest.mark.parametrize(
    "g, h",
    [
        ((0.1, 1.0, 0.3), (-0.1, -0.4, 0.8)),
        ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.2, 0.7, 0.7), (0.2, -0.7, -0.7)),
        ((0.05, 1.0, 0.0), (0.1, 1.0, 0.0)),
        ((3.0, 1.0, 1.0), (0.1, 0.2, 1.0)),
        ((-3.0, 1.0, 1.0), (0.1, 0.2, 1.0)),
    ],
)
def test_joint_coverage_is_the_area_that_two_edges_leave(g, h):
    g, h = linear(*g), linear(*h)
    assert joint_coverage(g, h)[0] == pytest.approx(np.mean((on_grid(g) > 0) & (on_grid(h) > 0)), abs=2e-3)


def test_joint_coverage_has_the_derivative_of_that_area():
    """Half the square is right of a vertical edge that moves by d: below a horizontal edge in the middle the area
    grows by d / 2.
    """
    slope = jax.grad(lambda d: joint_coverage(linear(0, 1, 0) - (-d), linear(0, 0, 1))[0])(0.1)
    assert slope == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize("mean", [coverage, ramp, lambda g: joint_coverage(g, g)])
@pytest.mark.parametrize("value", [0.0, 1e-30, -0.5, 1e6])
@pytest.mark.parametrize("slopes", [(0.0, 0.0), (1e-30, 0.0), (1e6, 0.0), (1e10, 1e10)])
def test_edges_of_the_means_are_finite(mean, value, slopes):
    point = jnp.asarray([value, *slopes], jnp.float32)

    def fn(p):
        return mean(Linear(p[0], p[1], p[2]))

    assert (
        np.isfinite(fn(point)) and np.isfinite(jax.jacfwd(fn)(point)).all() and np.isfinite(jax.grad(fn)(point)).all()
    )


def test_without_slopes_the_decision_is_hard_and_has_no_derivative():
    assert (
        coverage(linear(0.2, 0, 0))[0] == 1
        and coverage(linear(-0.2, 0, 0))[0] == 0
        and ramp(linear(0.2, 0, 0))[0] == 0.2
    )
    assert jax.grad(lambda x: coverage(Linear(x, x * 0, x * 0)))(0.2) == 0
    assert not is_cut(linear(0.2, 0, 0), 1e-3)[0]


def wave_on_grid(waves, slant=(0.0, 0.0)):
    product, depth = 1.0, 1 + slant[0] * U + slant[1] * V
    for w in waves:
        at = float(w.value[0]) + (float(w.across[0]) * U + float(w.down[0]) * V) / depth
        product = product * (1 - 2 * (np.floor(at) % 2))
    return np.mean(product)


@pytest.mark.parametrize(
    "first, second",
    [((0.1, 0.3, 0.2), (0.9, 0.1, -0.4)), ((2.5, 0.2, 0.1), (3.5, 0.1, 0.2)), ((1.02, 0.5, 0.1), (-0.01, 0.5, 0.1))],
)
def test_a_small_pixel_on_a_checkerboard_is_exact_where_both_edges_cross(first, second):
    waves = [linear(*first), linear(*second)]
    assert cell_mean(waves)[0] == pytest.approx(wave_on_grid(waves), abs=4e-3)


@pytest.mark.parametrize(
    "first, second, slant, off",
    [
        ((0.3, 0.2, 1.8), (0.7, 0.6, 0.1), (0.0, 0.0), 0.01),
        ((0.3, 0.1, 3.0), (5.2, 0.4, 0.3), (0.0, 0.5), 0.03),
        ((9.3, 0.3, 6.0), (5.2, 0.8, 0.3), (0.05, 1.2), 0.05),
        ((0.1, 40.0, 60.0), (0.2, 70.0, 3.0), (0.0, 0.0), 0.01),
    ],
)
def test_a_large_pixel_on_a_checkerboard_strip_by_strip(first, second, slant, off):
    waves = [linear(*first), linear(*second)]
    found = checker_mean(waves, tuple(jnp.asarray([s]) for s in slant))[0]
    assert found == pytest.approx(wave_on_grid(waves, slant), abs=off)


def test_where_the_colour_cannot_vary_nothing_is_averaged():
    flat = tuple(jnp.zeros(1) for _ in range(2))
    assert [bool(f[0]) for f in may_vary([linear(0.5, 0.1, 0.1), linear(1.5, 0.1, 0.1)], flat)] == [False, False]
    assert [bool(f[0]) for f in may_vary([linear(0.95, 0.1, 0.1), linear(1.5, 0.1, 0.1)], flat)] == [True, False]
    assert [bool(f[0]) for f in may_vary([linear(0.95, 0.1, 2.0), linear(1.5, 0.1, 0.1)], flat)] == [False, True]
