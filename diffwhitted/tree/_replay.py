"""The light of a recorded tree, differentiable in forward and reverse mode; or that of a tree as it is recorded."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Int

from ..geometry import Ray, beside_small
from ..numerics._safe import length
from ..numerics._stage import stage
from ..numerics._transposed import linear
from ..numerics._vector import Vec3
from ..scene import AbstractCamera, Tables
from ._arrival import Arrival
from ._motion import as_drawn
from ._plan import Plan
from ._pullback import Varied, pulled_back
from ._record import Nodes, Record, follow
from ._retrace import Given, light_of, retraced
from ._samples import Samples
from ._truncation import Beyond


def replay(
    tables: Tables,
    camera: AbstractCamera,
    record: Record,
    plan: Plan,
    samples: Samples,
    light_of: Callable = light_of,
    forward: bool = False,
) -> Vec3:
    """Linear RGB of the samples of a pass, three arrays of shape (plan.pass_pixels,).

    Differentiable in `tables`, `camera` and `samples`, along the recorded tree. `light_of` stands in place of the light
    of a node. `forward`: no reverse mode is wanted, so that picture and derivative come from one loop.
    """
    given = tables, camera, samples
    return retraced(light_of, plan, given, record)[0] if forward else _replayed(light_of, plan, given, record)


@partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def _replayed(light_of: Callable, plan: Plan, given: Given, record: Record) -> Vec3:
    return retraced(light_of, plan, given, record)[0]


@partial(_replayed.defjvp, symbolic_zeros=True)
def _replayed_jvp(light_of, plan, primals, tangents):
    given, record = primals
    varied, along = Varied.by(plan, tangents[0])

    def forward(known, tangents):
        given, record, _ = known

        def film(values):
            return retraced(light_of, plan, varied.replaced(given, values), record)[0]

        return jax.jvp(film, (varied.values(given),), (tangents,))[1]

    def backward(known, film):
        return pulled_back(light_of, plan, varied, *known, film)

    film, state = retraced(light_of, plan, given, record)
    return film, linear(forward, backward, (given, record, state), along)


def trace(
    tables: Tables, camera: AbstractCamera, plan: Plan, samples: Samples, beyond: Beyond | None = None
) -> tuple[Vec3, Vec3 | None, Int[Array, ""]]:
    """What `record` and `replay` give, in one go and without derivatives: the film, and the number of descendants.

    Between the two, where `beyond` is given, the most light that the branches that were not followed could bring.
    """
    tables, camera = as_drawn(tables, camera, plan, samples)
    tree, ((film,), left) = follow(
        tables, camera, plan, samples, lambda nodes, ray, *a: (light_of(tables, plan, nodes, *a),), beyond
    )
    return film, left, tree.descendants


def averaged(plan: Plan, samples: Samples, one: Callable):
    """What `one(samples)`, one of the functions here, gives in the mean over all that a place in a pixel takes; of the
    descendants, which it gives last, the most.
    """
    if plan.draws == 1:
        return one(samples)

    def add(total, draw):
        *light, descendants = one(replace(samples, draw=draw))
        *sums, most = total
        sums = jax.tree.map(lambda a, b: a + b / plan.draws, tuple(sums), tuple(light))
        return (*sums, jnp.maximum(most, descendants)), None

    first = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), jax.eval_shape(one, samples))
    return jax.lax.scan(add, first, jnp.arange(plan.draws, dtype=jnp.int32))[0]


def trace_left_out(
    tables: Tables, camera: AbstractCamera, plan: Plan, samples: Samples, beyond: Beyond
) -> tuple[Vec3, Int[Array, ""]]:
    """Of what `trace` gives with `beyond` only what is left out, and the number of descendants. `plan` must weigh its
    rays: have a cutoff.
    """
    tree, (_, left) = follow(*as_drawn(tables, camera, plan, samples), plan, samples, beyond=beyond)
    return left, tree.descendants


def trace_beside_small(
    tables: Tables, camera: AbstractCamera, plan: Plan, samples: Samples
) -> tuple[Vec3, Vec3, Int[Array, ""]]:
    """What `trace` gives, and between the two how much light comes along rays that pass by something smaller than
    their distance.
    """

    tables, camera = as_drawn(tables, camera, plan, samples)

    def both(nodes: Nodes, ray: Ray, at: Arrival, needed):
        reach, growth = (samples.side * apart for apart in camera.apart(ray.origin))
        limit = jnp.where(nodes.primitive < 0, jnp.inf, length(at.point - ray.origin))
        beside = stage(needed, lambda *a: beside_small(tables.shapes, *a), ray, reach, growth, limit)
        one = beside.astype(at.point.x.dtype)
        return light_of(tables, plan, nodes, at, needed), Vec3(one, one, one)

    tree, ((film, beside), _) = follow(tables, camera, plan, samples, both, kinds=2)
    return film, beside, tree.descendants
