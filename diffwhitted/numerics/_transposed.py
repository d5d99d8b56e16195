"""Linear functions that bring their transpose along: forward and reverse mode through a loop of unknown length.

JAX differentiates `lax.while_loop` forwards only. A `custom_vjp` would close forward mode, which Levenberg-Marquardt
needs, and a `scan` over all the steps that there might be clears and keeps memory for each of them. So this is a JAX
primitive of our own: the rule of a `custom_jvp` calls it for the tangent, and reverse mode finds the transpose in it.
"""

from collections.abc import Callable
from functools import cache, partial

import jax
import jax.numpy as jnp
from jax.extend import core
from jax.interpreters import ad, batching, mlir

_linear_p = core.Primitive("linear_with_transpose")
_linear_p.multiple_results = True


def linear(fun: Callable, transpose: Callable, residuals, tangents):
    """`fun(residuals, tangents)`, which is linear in `tangents`; reverse mode calls `transpose(residuals, cotangents)`.

    All four are pytrees of arrays. `transpose` gives back something like `tangents`. Neither function may close over
    traced values. Works under `jit`, `vmap`, `jvp`, `grad`, and forward over reverse (`jax.hessian`); in `residuals` it
    is as differentiable as the two functions are.
    """
    known, known_tree = jax.tree.flatten(residuals)
    moving, moving_tree = jax.tree.flatten(tangents)
    shapes = _shapes(*known, *moving)
    trees = []

    def forward(*leaves):
        given = jax.tree.unflatten(known_tree, leaves[: len(known)])
        out, tree = jax.tree.flatten(fun(given, jax.tree.unflatten(moving_tree, leaves[len(known) :])))
        trees.append(tree)
        return out

    program, results = jax.make_jaxpr(forward, return_shape=True)(*shapes)

    def backward(*leaves):
        given = jax.tree.unflatten(known_tree, leaves[: len(known)])
        out = transpose(given, jax.tree.unflatten(trees[0], leaves[len(known) :]))
        return jax.tree.leaves(out)

    transposed = cache(lambda: jax.make_jaxpr(backward)(*shapes[: len(known)], *results))
    out = _linear_p.bind(*known, *moving, program=program, transposed=transposed, known=len(known))
    return jax.tree.unflatten(trees[0], out)


def _shapes(*arrays) -> list[jax.ShapeDtypeStruct]:
    return [jax.ShapeDtypeStruct(jnp.shape(a), jnp.result_type(a)) for a in arrays]


@_linear_p.def_impl
def _run(*args, program, transposed, known):
    return jax.jit(core.jaxpr_as_fun(program))(*args)


@_linear_p.def_abstract_eval
def _shapes_of(*args, program, transposed, known):
    return program.out_avals


mlir.register_lowering(
    _linear_p,
    mlir.lower_fun(lambda *args, program, transposed, known: core.jaxpr_as_fun(program)(*args), multiple_results=True),
)


def _jvp(primals, tangents, *, program, transposed, known):
    """Along the tangents it is the function itself; in the residuals, whatever JAX finds in it."""
    bind = partial(_linear_p.bind, program=program, transposed=transposed, known=known)
    out, given = bind(*primals), tuple(primals[:known])
    along = tuple(map(ad.instantiate_zeros, tangents))
    total = bind(*given, *along[known:])
    if any(not isinstance(t, ad.Zero) for t in tangents[:known]):

        def of_residuals(*residuals):
            return core.jaxpr_as_fun(program)(*residuals, *primals[known:])

        _, more = jax.jvp(of_residuals, given, along[:known])
        total = [a + b for a, b in zip(total, more, strict=True)]
    return out, total


def _transpose(cotangents, *args, program, transposed, known):
    backward = transposed()
    filled = map(ad.instantiate_zeros, cotangents)
    out = _linear_p.bind(*args[:known], *filled, program=backward, transposed=lambda: program, known=known)
    moving = [ct if ad.is_undefined_primal(a) else None for ct, a in zip(out, args[known:], strict=True)]
    return [None] * known + moving


def _batch(args, axes, *, program, transposed, known):
    """A batch of it is linear too, with a batch of its transpose; what all share gets the sum of their cotangents."""
    size = next(a.shape[axis] for a, axis in zip(args, axes, strict=True) if axis is not None)
    args = [a if axis is None else jnp.moveaxis(a, axis, 0) for a, axis in zip(args, axes, strict=True)]
    mapped = [None if axis is None else 0 for axis in axes]
    shapes = _shapes(*args)

    def together(program, inputs):
        return jax.vmap(lambda *a: core.jaxpr_as_fun(program)(*a), in_axes=inputs, axis_size=size)

    forward = jax.make_jaxpr(together(program, mapped))(*shapes)

    def backward(*leaves):
        each = together(transposed(), [*mapped[:known], *[0] * len(program.out_avals)])(*leaves)
        return [ct.sum(axis=0) if axis is None else ct for ct, axis in zip(each, mapped[known:], strict=True)]

    batched = cache(lambda: jax.make_jaxpr(backward)(*shapes[:known], *_shapes(*forward.out_avals)))
    out = _linear_p.bind(*args, program=forward, transposed=batched, known=known)
    return out, [0] * len(out)


ad.primitive_jvps[_linear_p] = _jvp
ad.primitive_transposes[_linear_p] = _transpose
batching.primitive_batchers[_linear_p] = _batch
