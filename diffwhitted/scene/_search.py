"""The surfaces of a scene as families, and the trees of boxes by which those of many members are searched.

A tree is made on the host where the geometry is known, once for each geometry, and kept by its content. Within a
program whose geometry is traced, or is no longer the one that the tree was made of, it is made anew.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int

from ..geometry import AbstractSurfaces, BoxTree, Shapes, Sheets, Sides, boxes_over, compiled, prepare
from ..numerics._recent import Recent
from ..records import changed, is_traced
from ..shapes import OBJECTS, AbstractObject

MANY, MANY_COMPILED = 256, 32
"""A family of so many surfaces, or more, is searched by a tree; with machine code it pays earlier."""


class Meeting(eqx.Module):
    """Which triangles of a family meet at which sides (see `Triangles.sides`), and the tree of their sides."""

    side: Int[Array, "sides"]
    other: Int[Array, "sides"]
    known: "Known | None"


class Known(eqx.Module):
    """A tree, and the geometry that it was made of."""

    boxes: BoxTree
    columns: tuple[Array | None, ...]


_TREES: Recent[Known] = Recent(8)
"""Of geometry that comes again."""


def shapes_of(
    objects: Sequence[AbstractObject],
    known: Sequence[Known | None],
    sheets: Sheets | None,
    meetings: Sequence[Meeting | None] = (),
) -> Shapes:
    """The families of numbered objects, each with the tree by which it is searched; differentiable in the geometry.

    `known`: the trees of `known_boxes`, or none: then each is made here. `meetings`: those of `meetings_of`, where rays
    have footprints.
    """
    families, boxes, counts = [], [], []
    for number, (kind, mine, columns) in enumerate(_kinds(objects)):
        family = _family(kind, columns)
        families.append(family)
        single = kind.surfaces is AbstractObject.surfaces
        counts += [1] * len(mine) if single else [thing.surfaces for thing in mine]
        boxes.append(_current(family, columns, known[number] if known else None) if _searched(family) else None)
    sides = tuple(map(_sided, families, meetings)) if any(meetings) else ()
    if all(count == 1 for count in counts):
        return Shapes(tuple(families), sheets=sheets, boxes=tuple(boxes), sides=sides)
    of = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    first = (np.cumsum(counts) - counts).astype(np.int32)
    numbers = jnp.asarray(first), jnp.asarray(counts, jnp.int32)
    return Shapes(tuple(families), jnp.asarray(of), sheets, tuple(boxes), numbers, sides)


def meetings_of(objects: Sequence[AbstractObject], searched: bool) -> tuple[Meeting | None, ...]:
    """For each family of triangles which of them meet; `searched`: the tree of their sides too (see `known_boxes`)."""
    return tuple(_meeting(kind, mine, columns, searched) for kind, mine, columns in _kinds(objects))


def _meeting(kind: type[AbstractObject], mine: list, columns: tuple, searched: bool) -> Meeting | None:
    if (found := kind.sides(mine)) is None:
        return None
    side, other = map(jnp.asarray, found)
    if not searched or any(map(is_traced, jax.tree.leaves(columns))):
        return Meeting(side, other, None)
    sides = _sides(_family(kind, columns), side, other)
    return Meeting(side, other, _known(sides, tuple(jax.tree.leaves(sides))))


@eqx.filter_jit
def _sides(family: Any, side, other) -> Sides:
    return family.sides(side, other)


def _sided(family: AbstractSurfaces, meeting: Meeting | None) -> tuple[Sides, BoxTree | None] | None:
    """The sides of a family, and the tree by which they are searched."""
    if meeting is None:
        return None
    sides = _sides(family, meeting.side, meeting.other)
    columns = tuple(jax.tree.leaves(sides))
    if not _searched(sides):
        return sides, None
    return sides, _current(sides, columns, meeting.known)


def families_of(objects: Sequence[AbstractObject]) -> Iterator[AbstractSurfaces]:
    """The families of numbered objects."""
    return (_family(kind, columns) for kind, _, columns in _kinds(objects))


def with_families(shapes: Shapes, families: Sequence[AbstractSurfaces]) -> Shapes:
    """The same with other geometry; the trees of boxes are made of it, in the program."""

    def made(family, before):
        return before if before is None else _boxes_of(jax.lax.stop_gradient(family))

    def again(family, sided):
        if sided is None:
            return None
        sides = family.sides(sided[0].side, sided[0].other)
        return sides, made(sides, sided[1])

    boxes = tuple(made(*pair) for pair in zip(families, shapes.boxes, strict=True))
    sides = tuple(map(again, families, shapes.sides)) if shapes.sides else ()
    return changed(shapes, families=tuple(families), boxes=boxes, sides=sides)


def known_boxes(objects: Sequence[AbstractObject]) -> tuple[Known | None, ...]:
    """For each family the tree of its surfaces, where it has many and nothing of them is traced."""
    return tuple(_known(_family(kind, columns), columns) for kind, _, columns in _kinds(objects))


def _kinds(objects: Sequence[AbstractObject]) -> Iterator[tuple[type[AbstractObject], list, tuple]]:
    for kind in OBJECTS:
        mine = [thing for thing in objects if type(thing) is kind]
        if mine:
            yield kind, mine, tuple(kind.columns(mine))


@eqx.filter_jit
def _family(kind: type[AbstractObject], columns: tuple) -> AbstractSurfaces:
    return kind.family(*jax.tree.map(jnp.asarray, columns))


def _searched(family: AbstractSurfaces | Sides) -> bool:
    return family.BOUNDED and family.count >= (MANY_COMPILED if compiled(family) else MANY)


def _known(family: AbstractSurfaces | Sides, columns: tuple) -> Known | None:
    if not _searched(family) or any(map(is_traced, jax.tree.leaves(columns))):
        return None

    def made() -> Known:
        with jax.ensure_compile_time_eval():
            boxes = jax.tree.map(jnp.asarray, _boxes_of(family, np.asarray))
            return Known(boxes, jax.tree.map(jnp.asarray, columns))

    return _TREES.of([type(family).__name__, *jax.tree.leaves(columns)], made)


def _boxes_of(family: AbstractSurfaces | Sides, where: Callable = jnp.asarray) -> BoxTree:
    """The tree over the surfaces, or sides, of a family; `where`: made of NumPy's arrays it is made on the host."""
    boxes = boxes_over(*jax.tree.map(where, _extent(family)))
    return changed(boxes, cones=_cones(family, boxes.leaf)) if isinstance(family, Sides) else boxes


@eqx.filter_jit
def _cones(sides: Sides, leaf):
    return sides.cones(leaf)


@eqx.filter_jit
def _extent(family: AbstractSurfaces | Sides):
    """Corners of the boxes (n, 3) twice, and the numbers of the surfaces."""
    low, high = family.box()
    return low.stacked(), high.stacked(), family.numbers()


def _current(family: AbstractSurfaces | Sides, columns: tuple, known: Known | None) -> BoxTree:
    """The known tree, or one made here where the geometry may be, or is, another one."""
    prepare(family)

    family = jax.lax.stop_gradient(family)
    if known is None:
        return (_known(family, columns) or Known(_boxes_of(family), ())).boxes
    if not any(map(is_traced, jax.tree.leaves(columns))):
        return known.boxes
    columns = jax.lax.stop_gradient(columns)
    return jax.lax.cond(_same(columns, known.columns), lambda family: known.boxes, _boxes_of, family)


def _same(columns: tuple, others: tuple) -> Bool[Array, ""]:
    same = jnp.bool_(True)
    for one, other in zip(jax.tree.leaves(columns), jax.tree.leaves(others), strict=True):
        same = same & (jnp.asarray(one) == other).all()
    return same
