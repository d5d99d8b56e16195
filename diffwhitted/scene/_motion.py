"""Objects that move while a shutter is open: their surfaces as they change with the time.

A velocity only moves an object, and each number of a family of surfaces is linear in its place (and says so by its
derivative), so surfaces at any time are those at time 0 and a multiple of their rate.
"""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..geometry import Shapes
from ..numerics._vector import Vec3, vec3
from ..records import in_dtype
from ..shapes import AbstractObject
from ._search import families_of, with_families


class Motion(eqx.Module):
    """How the objects of tables move."""

    rates: Any
    """How each real number of the families of surfaces changes in a second; None in place of other numbers."""
    velocity: Vec3
    """Of each object, metres a second."""

    def at(self, shapes: Shapes, time: Float[Array, ""]) -> Shapes:
        """The surfaces at a time, seconds; differentiable. Trees of boxes are made anew, without derivatives."""
        real, rest = eqx.partition(shapes.families, eqx.is_inexact_array)
        moved = jax.tree.map(lambda number, rate: number + time * rate, real, self.rates)
        return with_families(shapes, eqx.combine(moved, rest))

    def shift(self, time: Float[Array, ""]) -> Vec3:
        """How far each object is from where it is stated, metres."""
        return self.velocity * time


def motion_of(objects: Sequence[AbstractObject], dtype) -> Motion | None:
    """The motion of numbered objects; None where none has a velocity."""
    if all(thing.velocity is None for thing in objects):
        return None
    still = np.zeros(3)
    velocity = [still if thing.velocity is None else thing.velocity for thing in objects]

    def real_numbers(time):
        moved = [thing if thing.velocity is None else _after(thing, thing.velocity * time, dtype) for thing in objects]
        return eqx.filter(tuple(families_of(moved)), eqx.is_inexact_array)

    zero = jnp.zeros((), dtype)
    rates = jax.jvp(real_numbers, (zero,), (jnp.ones_like(zero),))[1]
    return Motion(rates, vec3(jnp.stack([jnp.asarray(v, dtype) for v in velocity])))


def _after(thing: AbstractObject, shift, dtype) -> AbstractObject:
    """The same object, so many metres further on."""
    return in_dtype(thing.transformed(np.eye(3), shift, f"object {thing.name!r}"), dtype)
