"""The film of a pass under a user's own `jit`, where nothing is known of its rays: right at any number of them.

The samples are taken in windows, and a window whose tree outgrows the plan's room is halved and taken again. So the
room is that of a likely tree, not of the worst one, and time and memory follow the rays that there are. Without
derivatives the light is added up while the tree is followed; with them each window is recorded, and replayed along or
backwards.
"""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ..numerics._stage import empty_buffers
from ..numerics._transposed import linear
from ..numerics._vector import Vec3
from ._motion import as_drawn
from ._plan import Plan
from ._pullback import Varied, pulled_back
from ._record import follow, record
from ._retrace import Given, light_of, retraced
from ._samples import Window


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def film_of(plan: Plan, given: Given) -> tuple[Vec3, Bool[Array, ""]]:
    """Linear RGB of the samples of a pass, and whether the tree of a single one outgrew the room of the plan.

    Differentiable in forward and reverse mode in `given`: tables, camera and samples.
    """

    tables, camera = as_drawn(given[0], given[1], plan, given[2])

    def light(nodes, ray, *at):
        return (light_of(tables, plan, nodes, *at),)

    def traced(window, film):
        tree, ((more,), _) = follow(tables, camera, plan, given[2], light, window=window)
        return tree.descendants <= plan.capacity, lambda: jax.tree.map(jnp.add, film, more)

    return _in_windows(plan, traced, _dark(plan, given))


@partial(film_of.defjvp, symbolic_zeros=True)
def _film_of_jvp(plan, primals, tangents):
    varied, along = Varied.by(plan, tangents[0])

    def forward(given, tangents):
        def film(values):
            there = varied.replaced(given, values)

            def replayed(window, film):
                tree = record(*there[:2], plan, there[2], window)
                return tree.descendants <= plan.capacity, lambda: jax.tree.map(
                    jnp.add, film, retraced(light_of, plan, window.given(plan, there), tree)[0]
                )

            return _in_windows(plan, replayed, _dark(plan, given))[0]

        return jax.jvp(film, (varied.values(given),), (tangents,))[1]

    def backward(given, film):
        def reversed(window, total):
            tree, there = record(*given[:2], plan, given[2], window), window.given(plan, given)

            def pulled():
                state = retraced(light_of, plan, there, tree)[1]
                return jax.tree.map(jnp.add, total, pulled_back(light_of, plan, varied, there, tree, state, film))

            return tree.descendants <= plan.capacity, pulled

        return _in_windows(plan, reversed, jax.tree.map(jnp.zeros_like, varied.values(given)))[0]

    film, lost = film_of(plan, *primals)
    nothing = jax.custom_derivatives.zero_from_primal(lost)
    return (film, lost), (linear(forward, backward, *primals, along), nothing)


def _in_windows(plan: Plan, look: Callable, total):
    """The samples of a pass window by window: `look(window, total)` says whether its tree fits, and how to add it up.

    Also gives whether a window of one sample did not fit.
    """

    def unfinished(state):
        return state[0].first < plan.pass_pixels

    def step(state):
        window, total, lost = state
        fits, added = look(window, total)
        total = jax.lax.cond(fits, added, lambda: total)
        last = window.size == 1
        first = jnp.where(fits | last, window.first + window.size, window.first)
        return Window(first, jnp.where(fits | last, window.size, (window.size + 1) // 2)), total, lost | (~fits & last)

    first = Window(jnp.int32(0), jnp.int32(plan.pass_pixels)), total, jnp.bool_(False)
    return jax.lax.while_loop(unfinished, step, first)[1:]


def _dark(plan: Plan, given: Given) -> Vec3:
    one = given[0].cutoff
    return empty_buffers(Vec3(one, one, one), plan.pass_pixels)
