"""The searches in machine code, where there is any: on a CPU with numba, for kinds that `_machine` knows."""

import importlib
from functools import cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from ._boxes import BoxTree
from ._ray import Departure, Ray, Sheets
from ._surface import AbstractSurfaces

NEAREST, ANY, COUNT = range(3)
"""What is asked for: the first crossing, whether there is one before the limit, or how many of each kind."""


@cache
def _machine() -> Any:
    """The kernels; None where numba is missing."""
    try:
        return importlib.import_module("._machine", __package__)
    except ImportError:
        return None


def compiled(family: Any) -> bool:
    """Is there machine code for the searches of a family, here and now?"""
    return type(family).KERNEL is not None and jax.default_backend() == "cpu" and _machine() is not None


def prepare(family: Any) -> None:
    """Have the machine code for a family ready before a program that calls it runs, which may come from a file."""
    if compiled(family):
        _machine().target(type(family).KERNEL, jax.tree.leaves(family)[0].dtype.name)


def searcher(family: AbstractSurfaces, boxes: BoxTree | None, sheets: Sheets | None) -> Any:
    """What answers `nearest`, `blocked` and `crossing_counts` of a family: machine code, or the family itself.

    Where surfaces lie in one place the family itself does: it knows what is in the same sheet.
    """
    if boxes is None or boxes.members is None or sheets is not None or not compiled(family):
        return family
    return _Compiled(_machine().target(type(family).KERNEL, boxes.rows.dtype.name), family.count)


def compiled_sides(boxes: BoxTree, flags, asked: Any, creases: bool) -> Any:
    """The number and the distance of the side that `nearest_side` finds, by machine code; None where there is none."""
    if boxes.members is None or boxes.cones is None or jax.default_backend() != "cpu" or _machine() is None:
        return None
    dtype, ray = boxes.rows.dtype, asked.ray
    shape = ray.origin.shape
    results = jax.ShapeDtypeStruct(shape, jnp.int32), jax.ShapeDtypeStruct(shape, dtype)
    call = jax.ffi.ffi_call(_machine().target("side", dtype.name), results, vmap_method="sequential")
    ends = [part for end in asked.extra.ends for part in (end.x, end.y, end.z)]
    passed = jnp.stack(ends) if ends else jnp.zeros(1, dtype)
    limit = jnp.where(jnp.isnan(asked.limit), 0, asked.limit)
    return call(
        np.asarray([creases], np.int32), boxes.rows, boxes.leaf, boxes.members, flags,
        *jax.tree.leaves((ray.origin, ray.direction)), limit, asked.departure.primitive, asked.reach, asked.growth,
        passed, boxes.cones,
    )  # fmt: skip


class _Compiled(eqx.Module):
    """The searches of a family in machine code; as those of `AbstractSurfaces`."""

    target: str = eqx.field(static=True)
    count: int = eqx.field(static=True)

    def nearest(self, ray: Ray, departure: Departure, boxes: BoxTree):
        distance, number, crossing, _ = self._call(NEAREST, ray, departure, jnp.inf, boxes)
        return distance, number, crossing

    def blocked(self, ray: Ray, departure: Departure, limit, blocks, boxes: BoxTree) -> Bool[Array, "n"]:
        every = jnp.ones(self.count, jnp.int32) if blocks is None else jnp.asarray(blocks).astype(jnp.int32)
        return self._call(ANY, ray, departure, limit, boxes, every)[1] >= 0

    def crossing_counts(self, ray: Ray, departure: Departure, limit, kinds, count: int, boxes: BoxTree):
        return tuple(self._call(COUNT, ray, departure, limit, boxes, kinds, count)[3])

    def _call(self, mode: int, ray: Ray, departure: Departure, limit, boxes: BoxTree, flags=None, count: int = 0):
        shape, dtype = ray.origin.shape, boxes.rows.dtype
        flags = jnp.zeros(1, jnp.int32) if flags is None else flags
        results = (
            jax.ShapeDtypeStruct(shape, dtype),
            jax.ShapeDtypeStruct(shape, jnp.int32),
            jax.ShapeDtypeStruct(shape, jnp.int8),
            jax.ShapeDtypeStruct((count, *shape), jnp.int32),
        )
        limit = jnp.broadcast_to(jnp.asarray(limit, dtype), shape)
        limit = jnp.where(jnp.isnan(limit), 0, limit)
        numbers = (*jax.tree.leaves((ray.origin, ray.direction)), limit, departure.primitive, departure.inwards)
        call = jax.ffi.ffi_call(self.target, results, vmap_method="sequential")
        found = call(np.asarray([mode], np.int32), boxes.rows, boxes.leaf, boxes.members, flags, *numbers)
        distance = jnp.where(found[1] >= 0, found[0], jnp.inf) if mode == NEAREST else found[0]
        return distance, *found[1:]
