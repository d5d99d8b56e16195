"""Why a picture is black: what a person should look at first."""

import warnings
from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np

from .._errors import SceneNote
from ..scene import AbstractCamera, Scene, is_traced, most_ambient
from ..tree import Plan


def note_if_black(scene: Scene, camera: AbstractCamera, plan: Plan, image) -> None:
    """Warn of a picture without any light, with the reason where one is found."""
    if not any(map(is_traced, jax.tree.leaves((scene, camera, image)))) and not np.any(np.asarray(image)):
        reason = next(_reasons(scene, camera, plan), "no light reaches what the camera sees")
        warnings.warn(f"the picture is entirely black: {reason}", SceneNote, stacklevel=3)


def _reasons(scene: Scene, camera: AbstractCamera, plan: Plan) -> Iterator[str]:
    """What makes it black, the surest reason first."""
    if not scene.objects:
        yield "there is no object, and the background is black; add an [[object]]"
        return
    eye = np.asarray(camera.look_from, np.float64)
    placed = scene.placed_objects()
    closed = [thing for thing in placed if thing.solid and not _some(_material(scene, thing).k_t)]
    # Where the camera is, and what is before it.
    places = [place for light in scene.lights if (place := light.place()) is not None]
    for thing in closed:
        if thing.holds(eye) and not any(map(thing.holds, places)):
            yield f"the camera is inside object {thing.name!r}, which lets no light in (k_t = 0); move one of the two"
    if all(map(_outside_of_view(camera), placed)):
        behind = "behind the camera" if all(map(_behind(camera), placed)) else "outside the view of the camera"
        yield f"every object is {behind}, and the background is black; change look_from, look_at or vfov_deg"
    # What could bring light.
    used = {thing.material: _material(scene, thing) for thing in scene.objects}.values()
    glows = _some(most_ambient(scene.ambient)) and any(_some(m.k_a) for m in used)
    lit = any(_some(m.k_d) or (m.highlight != "off" and _some(m.highlight_coefficient())) for m in used)
    lamps = [light for light in scene.lights if _some(getattr(light, "colour", 1))]
    if scene.background.lights_surfaces:
        pass
    elif not glows and not scene.lights:
        yield "the scene has no light, no object reflects ambient light (k_a), the background is black; add a [[light]]"
    elif not glows and not lamps:
        yield "every light has colour 0; give one a colour"
    elif not glows and not lit:
        yield "no object has k_a, k_d or k_h > 0, and the background is black; give a material a k_d"
    for light in lamps if not glows and scene.shadows != "off" else ():
        place = light.place()
        around = next((thing for thing in closed if place is not None and thing.holds(place)), None)
        if around is not None:
            inside = f"light {light.name!r} is inside object {around.name!r}"
            yield f"{inside}, which lets no light out (k_t = 0); move one of the two"
    if plan.max_depth == 1 and any(_some(m.k_s) or _some(m.k_t) for m in used):
        yield "max_depth = 1 follows no ray past the first surface; raise it"


def _material(scene: Scene, thing):
    return scene.materials[thing.material]


def _some(value) -> bool:
    return bool(np.any(np.asarray(value) > 0))


def _ahead(camera: AbstractCamera) -> np.ndarray:
    ahead = np.asarray(camera.look_at, np.float64) - np.asarray(camera.look_from, np.float64)
    return ahead / np.linalg.norm(ahead)


def _behind(camera: AbstractCamera):
    """Does the bounding sphere of an object lie behind the camera?"""
    eye, ahead = np.asarray(camera.look_from, np.float64), _ahead(camera)

    def of(thing) -> bool:
        middle, radius = thing.ball()
        return bool((middle - eye) @ ahead + radius <= 0)

    return of


def _outside_of_view(camera: AbstractCamera):
    """Does it lie outside the cone around the picture?"""
    eye, ahead = np.asarray(camera.look_from, np.float64), _ahead(camera)
    corners = camera.rays(
        jnp.asarray([0.0, camera.width] * 2, camera.look_from.dtype),
        jnp.asarray([0.0] * 2 + [camera.height] * 2, camera.look_from.dtype),
    )
    starts, ways = (np.stack([v.x, v.y, v.z], axis=-1) for v in (corners.origin, corners.direction))
    # Rays that start side by side fill no cone.
    widest = np.pi if np.ptp(starts, axis=0).any() else float(np.arccos(np.clip(ways @ ahead, -1, 1)).max())

    def of(thing) -> bool:
        middle, radius = thing.ball()
        away = float(np.linalg.norm(middle - eye))
        if not away > radius:
            return False
        angle = np.arccos(np.clip((middle - eye) @ ahead / away, -1, 1))
        return bool(angle - np.arcsin(radius / away) > widest)

    return of
