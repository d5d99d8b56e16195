"""Ambient light that comes from a sky above and a ground below."""

from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..numerics._safe import normalise, rescaled
from ..numerics._vector import Vec3, dot, vec3
from ..records import Row, is_traced, read_rows


class Hemisphere(eqx.Module):
    """Ambient light by the way that a surface faces: `sky` (1 + N.up) / 2 + `ground` (1 - N.up) / 2, linear RGB.

    What a surface with the normal N gets of a hemisphere of one colour above and one of another below; `up` is any
    vector but zero. It stands in place of a scene's `ambient`, multiplied by k_a like it.
    """

    ROWS: ClassVar[tuple[Row, ...]] = (
        Row("sky", "colour", "Linear RGB of what a surface that faces up gets; multiplies k_a.", lowest=0),
        Row("ground", "colour", "Linear RGB of what a surface that faces down gets; multiplies k_a.", lowest=0),
        Row("up", "direction", "Towards the middle of the sky; any length but zero.", default=(0.0, 1.0, 0.0),
            nonzero=True, scale="unbounded"),
    )  # fmt: skip

    sky: Float[Array, "3"]
    ground: Float[Array, "3"]
    up: Float[Array, "3"]

    def __init__(self, sky, ground, up=(0.0, 1.0, 0.0), place: str = "scene: ambient"):
        read_rows(self, place, sky=sky, ground=ground, up=up)

    def at(self, normal: Vec3) -> Vec3:
        """What a surface with this unit normal gets; differentiable."""
        height = 0.5 * (1 + dot(normal, normalise(rescaled(vec3(self.up))[0])))
        return vec3(self.sky) * height + vec3(self.ground) * (1 - height)

    def even(self):
        """The mean of sky and ground, alike for all surfaces, (3,)."""
        return 0.5 * (self.sky + self.ground)


Ambient = Float[Array, "3"] | Hemisphere


def most_ambient(ambient: Ambient) -> Any:
    """The most ambient light that any surface gets, (3,)."""
    if not isinstance(ambient, Hemisphere):
        return ambient
    some = jnp if is_traced(ambient.sky) or is_traced(ambient.ground) else np
    return some.maximum(ambient.sky, ambient.ground)
