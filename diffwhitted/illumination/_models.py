"""Models of the highlight: the difference of two unit vectors whose angle decides it. A new model is a row here."""

from collections.abc import Callable, Sequence

import jax.numpy as jnp
from jaxtyping import Array, Int

from ..numerics._safe import normalise
from ..numerics._vector import Vec3, where
from ..optics import mirrored
from ..scene import HIGHLIGHTS


def halfway_apart(normal: Vec3, to_light: Vec3, incoming: Vec3) -> Vec3:
    """N - H with H the unit vector halfway between L and V = -u: where `lobe` gives (N.H)**n, the k_h term of Whitted
    (1).
    """
    return normal - normalise(to_light - incoming)


def reflected_apart(normal: Vec3, to_light: Vec3, incoming: Vec3) -> Vec3:
    """L - R' with R' the mirrored incoming ray: where `lobe` gives (V.R)**n, Hearn and Baker (14-6)."""
    return to_light - mirrored(incoming, normal)


MODELS: dict[str, Callable[[Vec3, Vec3, Vec3], Vec3]] = {"halfway": halfway_apart, "reflected": reflected_apart}


def apart(models: Sequence[str], model: Int[Array, "n"] | None, normal: Vec3, to_light: Vec3, incoming: Vec3) -> Vec3:
    """The difference by the model of each point, of the models that there are in the scene."""
    found = [(name, MODELS[name](normal, to_light, incoming)) for name in MODELS if name in models]
    if not found:
        zero = jnp.zeros_like(normal.x)
        return Vec3(zero, zero, zero)
    value = found[0][1]
    for name, other in found[1:]:
        value = where(model == HIGHLIGHTS.index(name), other, value)
    return value
