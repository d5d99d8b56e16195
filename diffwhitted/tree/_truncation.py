"""Where the tree ends: past the depth limit, and where a branch would carry less than the cutoff.

A child carries its parent's throughput times the coefficient of its branch (Hall and Greenberg 1983 end the tree by
that, "adaptive depth"). What the children that are not followed could have brought is at most the sum of their
throughputs, each times the most light that can come along its ray.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from ..numerics._vector import Vec3, brightest, lookup, where
from ..scene import Tables
from ._arrival import TRANSMITTED, Arrival
from ._plan import Plan
from ._weights import weighed_point, weight

Children = tuple[Int[Array, "n"], Bool[Array, "n"], Bool[Array, "n"] | None]
"""The mirror child (0 for none, else its branch), whether there is a transmitted one, and one that runs past."""


def followed(
    tables: Tables,
    plan: Plan,
    at: Arrival,
    level: Int[Array, "n"],
    throughput: Vec3 | None,
    children: Children,
    needed,
    lit: bool = False,
) -> Children:
    """Those of the children that are followed. What runs past a silhouette is no deeper than its parent, and always is.

    A branch that weighs nothing is followed for the derivative in its weight, but not where its parent carries
    nothing either: no first derivative comes from there. With `lit`, where no derivative is asked for, it ends the
    tree.
    """
    mirror, through, past = children
    deeper = level < (plan.max_depth if tables.max_depth is None else tables.max_depth)
    keep_mirror = keep_through = deeper
    if plan.effects.cutoff or plan.zero_weights or lit:
        point, transmitted = weighed_point(tables, plan, at, needed), jnp.full_like(mirror, TRANSMITTED)
        weights = weight(plan, point, mirror), weight(plan, point, transmitted)
    if lit:
        keep_mirror, keep_through = (deeper & _any(throughput * w) for w in weights)
    elif plan.zero_weights:
        alive = _any(throughput)
        keep_mirror, keep_through = (deeper & (alive | _any(w)) for w in weights)
    if plan.effects.cutoff:
        enough = [brightest(throughput * w) >= tables.cutoff for w in weights]
        keep_mirror, keep_through = keep_mirror & enough[0], keep_through & enough[1]
    return jnp.where(keep_mirror, mirror, 0), through & keep_through, past


class Beyond(eqx.Module):
    """How much light a ray can bring at most, by the number of the object that it leaves."""

    outwards: Vec3
    inwards: Vec3


def left_out(
    tables: Tables,
    plan: Plan,
    beyond: Beyond,
    at: Arrival,
    throughput: Vec3,
    children: Children,
    kept: Children,
    needed,
) -> Vec3:
    """The most light that the children that are not followed could bring; where no finite amount is known, infinite."""
    point, transmitted = weighed_point(tables, plan, at, needed), jnp.full_like(children[0], TRANSMITTED)
    mirror, through = ((children[0] > 0) & (kept[0] == 0), children[0]), (children[1] & ~kept[1], transmitted)
    out, into = lookup(beyond.outwards, at.object), lookup(beyond.inwards, at.object)
    total = jax.tree.map(jnp.zeros_like, throughput)
    for (gone, branch), most in ((mirror, where(at.entering, out, into)), (through, where(at.entering, into, out))):
        carried = throughput * weight(plan, point, branch)
        # Where nothing is carried nothing is left out, be the most infinite.
        total = total + jax.tree.map(lambda c, m, gone=gone: jnp.where(gone & (c > 0), c * m, 0), carried, most)
    return total


def _any(colour: Vec3) -> Bool[Array, "n"]:
    """Is any channel other than zero? A difference may try a coefficient a little below it."""
    return (colour.x != 0) | (colour.y != 0) | (colour.z != 0)
