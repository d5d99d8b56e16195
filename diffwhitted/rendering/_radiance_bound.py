"""How much light a ray can bring at most, by the object that it leaves and the side on which it does.

    out(o) = max(background, hit(p) for p that a ray from the outside of o may meet next)
    hit(p) = local(p) + k_s out(p) + k_t in(p) from outside,  local(p) + k_s in(p) + k_t out(p) from inside,

from 0 upwards, level by level, so that after n rounds no tree of n levels is brighter. `local` is all that ambient
light and lamps can do. A surface that a ray leaves is not what it meets next unless the ray is inside of it (all
shapes are convex), and what lies apart from a solid is never met from within it. Where total internal reflection is
possible the reflected side may pass on everything in place of k_s and k_t. From outside a sphere that stands alone it
is not: a ray that was refracted into it meets its surface at the same angle from within.
"""

import jax.numpy as jnp
import numpy as np

from ..numerics._vector import vec3
from ..scene import DEEPEST, Camera, Plane, Scene, Sphere, numbered_objects
from ..tree import Beyond, Plan


def most_beyond(scene: Scene, camera: Camera, plan: Plan) -> Beyond:
    """The most light that can come along a ray that leaves each object, for the tracer; infinite past the largest
    number of its precision.
    """
    with np.errstate(over="ignore"):
        return Beyond(*(vec3(jnp.asarray(side.astype(scene.dtype))) for side in radiance_bounds(scene, camera, plan)))


def radiance_bounds(scene: Scene, camera: Camera, plan: Plan) -> np.ndarray:
    """Most radiance that comes along a ray that leaves each object, outwards and inwards: (2, objects, 3), linear RGB.

    Of trees of up to `DEEPEST` levels.
    """
    objects = numbered_objects(scene)
    background = np.asarray(scene.background.brightest())
    local, k_s, k_t = (np.stack(rows) for rows in zip(*(_material(scene, o) for o in objects), strict=True))
    within = np.stack([_local_inside(scene, o, row) for o, row in zip(objects, local, strict=True)])
    near = np.asarray([[i == j or not _apart(a, b) for j, b in enumerate(objects)] for i, a in enumerate(objects)])
    solid = np.asarray([isinstance(o, Sphere) for o in objects])
    others = ~np.eye(len(objects), dtype=bool)
    total = np.asarray(
        [
            plan.effects.total_internal_reflection
            and plan.total_reflection_is_full
            and bool(t.any())
            and not (s and (n & o).sum() == 0 and not _holds(thing, camera))
            for thing, t, s, n, o in zip(objects, k_t, solid, near, others, strict=True)
        ]
    )[:, None]
    out = into = np.zeros_like(local)
    for _ in range(DEEPEST):
        from_outside = local + np.maximum(k_s * out + k_t * into, total * out)
        from_inside = within + np.maximum(k_s * into + k_t * out, total * into)
        either = np.maximum(from_outside, from_inside)
        met = np.where((near | ~solid[None])[..., None], either[None], from_outside[None])
        outwards = np.maximum(background, _most(met, others))
        out, into = outwards, np.where(solid[:, None], np.maximum(from_inside, _most(met, others & near)), outwards)
    return np.stack([out, into])


def _most(met: np.ndarray, possible: np.ndarray) -> np.ndarray:
    """The brightest of what may be met, by the object that the ray leaves."""
    return np.where(possible[..., None], met, 0).max(axis=1, initial=0)


def _material(scene: Scene, thing) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The most light of its own, k_s and k_t of an object, (3,) each."""
    m = scene.materials[thing.material]
    k_a, k_d, k_s, k_t = (np.broadcast_to(np.asarray(k, np.float64), 3) for k in (m.k_a, m.k_d, m.k_s, m.k_t))
    k_h = 0.0 if m.highlight == "off" else np.broadcast_to(np.asarray(m.highlight_coefficient(), np.float64), 3)
    on_k_a, on_k_d = (1.0 if t is None else scene.textures[t].brightest() for t in (m.k_a_texture, m.k_d_texture))
    lamps = sum((np.asarray(light.colour, np.float64) for light in scene.lights), np.zeros(3))
    return k_a * on_k_a * np.asarray(scene.ambient, np.float64) + (k_d * on_k_d + k_h) * lamps, k_s, k_t


def _local_inside(scene: Scene, thing, local: np.ndarray) -> np.ndarray:
    """The same on the inside: the object's own surface hides all lamps outside it where shadows are opaque."""
    if (
        scene.shadows != "opaque"
        or not isinstance(thing, Sphere)
        or any(_holds(thing, light) for light in scene.lights)
    ):
        return local
    m = scene.materials[thing.material]
    pattern = 1.0 if m.k_a_texture is None else scene.textures[m.k_a_texture].brightest()
    return np.broadcast_to(np.asarray(m.k_a, np.float64), 3) * pattern * np.asarray(scene.ambient, np.float64)


def _holds(sphere: Sphere, thing) -> bool:
    """Is a camera or a lamp inside the sphere, or on it?"""
    place = getattr(thing, "look_from", None) if hasattr(thing, "look_from") else getattr(thing, "position", None)
    return place is not None and bool(
        np.linalg.norm(np.asarray(place, np.float64) - _centre(sphere)) <= float(sphere.radius)
    )


def _apart(a, b) -> bool:
    """Is it certain that no part of either lies inside the other?"""
    if isinstance(a, Sphere) and isinstance(b, Sphere):
        return bool(np.linalg.norm(_centre(a) - _centre(b)) >= float(a.radius) + float(b.radius))
    plane, sphere = (a, b) if isinstance(a, Plane) else (b, a)
    if isinstance(plane, Plane) and isinstance(sphere, Sphere):
        normal = np.asarray(plane.normal, np.float64)
        size = np.linalg.norm(normal)
        return bool(normal @ _centre(sphere) / size - float(plane.offset) / size >= float(sphere.radius))
    return False


def _centre(sphere: Sphere) -> np.ndarray:
    return np.asarray(sphere.centre, np.float64)
