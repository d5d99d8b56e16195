"""What can only be known while a program runs: traced numbers that outgrow the plan of a picture.

Under a user's own `jit`, `grad` or `vmap` there is nobody to raise an error, and a callback to the host would keep the
program out of every cache of compiled programs. So a picture that would be wrong is NaN there, all of it, and so are
its derivatives in every number, also in those that the program does not read.
"""

from collections import Counter
from functools import reduce

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..scene import Material, Polygon, Scene, Sphere, is_traced, numbered_objects
from ..tree import Plan


def unforeseen(scene: Scene, plan: Plan) -> Bool[Array, ""]:
    """Do the numbers of the scene call for something that the plan leaves out? At the cost of a few sums.

    Meant for traced numbers: what is known before is checked before, and has its own message. The conditions are those of `decide_effects`, on values in place of what was known when the plan was made.
    """
    left_out = [called for name, called in _called_for(scene, plan).items() if not getattr(plan.effects, name)]
    return reduce(jnp.logical_or, [*left_out, *_objects_left_out(scene, plan)], jnp.bool_(False))


@jax.custom_jvp
def poisoned(image: Float[Array, "height width 3"], inputs, wrong: Bool[Array, ""]) -> Float[Array, "height width 3"]:
    """The image, and where it is `wrong` NaN: every pixel, and every derivative in `inputs`, a pytree of arrays."""
    return jnp.where(wrong, jnp.nan, image)


@poisoned.defjvp
def _poisoned_jvp(primals, tangents):
    image, inputs, wrong = primals
    along, of_inputs, _ = tangents
    moving = [jnp.sum(t) for t in jax.tree.leaves(of_inputs) if jnp.issubdtype(t.dtype, jnp.inexact)]
    spoilt = sum(moving, jnp.zeros((), image.dtype)) * jnp.where(wrong, jnp.nan, 0)
    return poisoned(image, inputs, wrong), along * jnp.where(wrong, jnp.nan, 1) + spoilt.astype(image.dtype)


def _called_for(scene: Scene, plan: Plan) -> dict[str, Bool[Array, ""] | bool]:
    """By the name of an effect: does some number call for it? Left out are those that numbers do not decide."""
    objects_of, solids_of = (
        Counter(o.material for o in objects)
        for objects in (scene.objects, (o for o in scene.objects if not isinstance(o, Polygon)))
    )
    used = [scene.materials[name] for name in sorted(objects_of)]
    glass, solids = (
        sum((count * _positive(scene.materials[name].k_t) for name, count in counted.items()), jnp.zeros((), int))
        for counted in (objects_of, solids_of)
    )
    deep, lit = plan.max_depth > 1, bool(scene.lights)
    textured = [(m.k_a, m.k_a_texture) for m in used] + [(m.k_d, m.k_d_texture) for m in used]
    return {
        "ambient": _any(m.k_a for m in used) & _positive(scene.ambient),
        "diffuse": _any(m.k_d for m in used) & lit,
        "highlight": _any(m.highlight_coefficient() for m in used if m.highlight != "off") & lit,
        "reflection": _any(m.k_s for m in used) & deep,
        "refraction": (glass > 0) & deep,
        "tinted_shadows": (glass > 0) & (scene.shadows == "tinted") & plan.effects.shadows,
        "total_internal_reflection": reduce(jnp.logical_or, map(_dense, used), jnp.bool_(False)) & deep,
        "nested_media": (glass > 1) & (solids > 0) & deep,
        "textures": _any(value for value, texture in textured if texture is not None),
        "cutoff": _positive(scene.cutoff) & plan.effects.branching,
    }


def _objects_left_out(scene: Scene, plan: Plan) -> list[Bool[Array, ""]]:
    """What the plan knows of single objects, and the numbers contradict."""
    objects = numbered_objects(scene)
    without_mirror, opaque = (
        {o.material for o, has in zip(objects, flags, strict=True) if not has}
        for flags in (plan.mirrors, plan.transparent)
    )
    found = [_positive(scene.materials[name].k_s) & (plan.max_depth > 1) for name in sorted(without_mirror)]
    found += [_positive(scene.materials[name].k_t) & (plan.max_depth > 1) for name in sorted(opaque)]
    sizes = [objects[n].radius for n in plan.solids if isinstance(objects[n], Sphere)]
    return found + [a > b for a, b in zip(sizes, sizes[1:], strict=False) if is_traced(a) or is_traced(b)]


def _positive(value) -> Bool[Array, ""]:
    return jnp.any(jnp.asarray(value) > 0)


def _any(values) -> Bool[Array, ""]:
    return reduce(jnp.logical_or, map(_positive, values), jnp.bool_(False))


def _dense(material: Material) -> Bool[Array, ""]:
    """Is it transparent, with an index at which light may be reflected in whole?"""
    return _positive(material.k_t) & _positive(material.refractive_index - 1)
