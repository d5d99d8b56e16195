"""What lies on either side of a surface, where glass lies in glass or touches it."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..geometry import NOTHING, Hit, containing, neighbours, sheet_at
from ..numerics._vector import lookup
from ..scene import Tables
from ._made_of import index_of
from ._plan import Plan

Medium = Int[Array, "n"] | None


def media(tables: Tables, plan: Plan, hit: Hit, dark: Bool[Array, "n"]) -> tuple[Medium, Medium]:
    """The object whose index counts on the outer side of a surface, -1 for none, and the one on its inner side.

    None where the plan knows no such thing: nothing outside, the object itself inside. `dark`: the ray carries no
    light, and is followed for a derivative: all that may be glass counts.
    """
    shapes, clear, outside = tables.shapes, lookup(tables.clear, tables.material_of), None
    sheets = shapes.sheets if plan.effects.shared_surfaces else None
    here = None if sheets is None else sheet_at(sheets, hit.primitive)

    def counted(number):
        """What is in the same sheet begins or ends at the very point: its layers tell."""
        counts = clear[number] | dark
        return counts if here is None else counts & ((here < 0) | (sheets.sheet[shapes.first_surface(number)] != here))

    # Find the solid that surrounds the object.
    if plan.effects.nested_media:
        outside = containing(shapes, hit.point, tables.marks.solids, tables.rank, hit.object, counted)
    if sheets is None:
        return outside, None
    # Find what lies at either end of the sheet.
    outside = jnp.full_like(hit.object, NOTHING) if outside is None else outside
    around = neighbours(shapes, hit, shapes.by_surface(tables.rank), lambda k: clear[shapes.object_at(k)] | dark)
    below, above = (jnp.where(end >= 0, shapes.object_at(end), outside) for end in (around.below, around.above))
    # Between two layers of glass is the denser of the two: what an infinitely thin film does not reflect totally.
    between = jnp.where(
        around.opaque, outside, jnp.where(index_of(tables, below) > index_of(tables, above), below, above)
    )
    facing = lookup(sheets.facing, jnp.maximum(hit.primitive, 0))
    outer, inner = jnp.where(facing, above, below), hit.object
    more_outside = jnp.where(facing, around.more_above, around.more_below)
    more_inside = jnp.where(facing, around.more_below, around.more_above)
    alone = here < 0
    return (
        jnp.where(alone, outside, jnp.where(more_outside, between, outer)),
        jnp.where(alone | ~more_inside, inner, between),
    )
