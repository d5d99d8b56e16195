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

from ..scene import AbstractCamera, Material, Scene, most_ambient
from ..tree import Plan, effect_rows


def unforeseen(scene: Scene, plan: Plan, camera: AbstractCamera | None = None) -> Bool[Array, ""]:
    """Do the numbers of scene and camera call for something that the plan leaves out? At the cost of a few sums.

    Meant for traced numbers: what is known before is checked before, and has its own message. The conditions are those
    of `decide_effects`, on values in place of what was known when the plan was made.
    """
    left_out = [called for name, called in _called_for(scene, plan, camera).items() if name not in plan.effects]
    return reduce(jnp.logical_or, left_out, jnp.bool_(False))


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


def _called_for(scene: Scene, plan: Plan, camera: AbstractCamera | None) -> dict[str, Bool[Array, ""] | bool]:
    """By the name of an effect: does some number call for it? Left out are those that numbers do not decide."""
    objects_of, solids_of = (
        Counter(o.material for o in objects) for objects in (scene.objects, (o for o in scene.objects if o.solid))
    )
    used = [scene.materials[name] for name in sorted(objects_of)]
    glass, solids = (
        sum((count * _positive(scene.materials[name].k_t) for name, count in counted.items()), jnp.zeros((), int))
        for counted in (objects_of, solids_of)
    )
    deep, lit = plan.max_depth > 1, bool(scene.lights)
    between = scene.radiosity is not None
    surrounded = scene.background.lights_surfaces
    added: dict[str, Bool[Array, ""] | bool] = {
        row.name: _any(m.values[name] for m in used for name in row.coefficients)
        for row in effect_rows()
        if row.coefficients
    }
    return added | {
        "absorption": reduce(jnp.logical_or, map(_absorbs, used), jnp.bool_(False)) & deep,
        "ambient": _any(m.at_work("k_a") for m in used) & _positive(most_ambient(scene.ambient)) & (not between),
        "radiosity": _any(m.k_d for m in used) & between,
        "diffuse": _any(m.k_d for m in used) & lit,
        "highlight": _any(m.highlight_coefficient() for m in used if m.highlight != "off") & lit,
        "environment": _any(m.k_d for m in used) & surrounded,
        "environment_highlight": _any(m.k_h for m in used if m.is_shiny) & surrounded,
        "reflection": _any(m.k_s for m in used) & deep,
        "refraction": (glass > 0) & deep,
        "tinted_shadows": (glass > 0) & (scene.shadows == "tinted") & plan.effects.shadows,
        "total_internal_reflection": reduce(jnp.logical_or, map(_dense, used), jnp.bool_(False)) & deep,
        "nested_media": (glass > 1) & (solids > 0) & deep,
        "textures": _any(m.at_work(name) for m in used for name, _ in m.textures),
        "lens": _is_some(camera, "aperture"),
        "motion": _is_some(camera, "shutter") & _moves(scene, camera),
        "cutoff": _positive(scene.cutoff) & plan.effects.branching,
    }


def _absorbs(material: Material) -> Bool[Array, ""]:
    return _positive(material.k_t) & _positive(material.extinction)


def _is_some(camera: AbstractCamera | None, key: str) -> Bool[Array, ""]:
    value = None if camera is None else getattr(camera, key)
    return jnp.bool_(False) if value is None else _positive(value)


def _moves(scene: Scene, camera: AbstractCamera | None) -> Bool[Array, ""]:
    velocities = (thing.velocity for thing in (*scene.objects, camera) if thing and thing.velocity is not None)
    return _any(abs(velocity) for velocity in velocities)


def _positive(value) -> Bool[Array, ""]:
    return jnp.any(jnp.asarray(value) > 0)


def _any(values) -> Bool[Array, ""]:
    return reduce(jnp.logical_or, map(_positive, values), jnp.bool_(False))


def _dense(material: Material) -> Bool[Array, ""]:
    """Is it transparent, with an index at which light may be reflected in whole?"""
    return _positive(material.k_t) & _positive(material.at_work("refractive_index") - 1)
