"""Where the tree ends: past the depth limit, and where a branch would carry less than the cutoff.

A child carries its parent's throughput times the coefficient of its branch (Hall and Greenberg 1983 end the tree by that,
"adaptive depth"). What the children that are not followed could have brought is at most the sum of their throughputs, each
times the most light that can come along its ray.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..numerics._vector import Vec3, lookup, where
from ..scene import Tables
from ._arrival import TRANSMITTED, Arrival
from ._branch import share
from ._plan import Plan

Children = tuple[Int[Array, "n"], Bool[Array, "n"], Bool[Array, "n"] | None]
"""The mirror child (0 for none, else its branch), whether there is a transmitted one, and one that runs past."""


def followed(
    tables: Tables,
    plan: Plan,
    at: Arrival,
    level: Int[Array, "n"],
    throughput: Vec3 | None,
    children: Children,
    lit: bool = False,
) -> Children:
    """Those of the children that are followed. What runs past an outline is no deeper than its parent, and always is.

    With `lit` only those that carry light: where no derivative is asked for, a coefficient that is zero ends the tree.
    """
    mirror, through, past = children
    deeper = level < (plan.max_depth if tables.max_depth is None else tables.max_depth)
    keep_mirror = keep_through = deeper
    if plan.effects.cutoff or lit:
        carried = (
            _brightest(throughput * share(tables, plan, at.object, branch))
            for branch in (mirror, jnp.full_like(mirror, TRANSMITTED))
        )
        keep_mirror, keep_through = (
            deeper & ((light > 0) if lit else True) & ((light >= tables.cutoff) if plan.effects.cutoff else True)
            for light in carried
        )
    return jnp.where(keep_mirror, mirror, 0), through & keep_through, past


class Beyond(eqx.Module):
    """How much light a ray can bring at most, by the number of the object that it leaves."""

    outwards: Vec3
    inwards: Vec3


def left_out(
    tables: Tables, plan: Plan, beyond: Beyond, at: Arrival, throughput: Vec3, children: Children, kept: Children
) -> Vec3:
    """The most light that the children that are not followed could bring; where no finite amount is known, infinite."""
    transmitted = jnp.full_like(children[0], TRANSMITTED)
    mirror, through = ((children[0] > 0) & (kept[0] == 0), children[0]), (children[1] & ~kept[1], transmitted)
    out, into = lookup(beyond.outwards, at.object), lookup(beyond.inwards, at.object)
    total = throughput * 0
    for (gone, branch), most in ((mirror, where(at.entering, out, into)), (through, where(at.entering, into, out))):
        carried = throughput * share(tables, plan, at.object, branch)
        # Where nothing is carried nothing is left out, be the most infinite.
        total = total + jax.tree.map(lambda c, m, gone=gone: jnp.where(gone & (c > 0), c * m, 0), carried, most)
    return total


def _brightest(colour: Vec3):
    return jnp.maximum(jnp.maximum(colour.x, colour.y), colour.z)
