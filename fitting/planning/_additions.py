"""What may be put elsewhere: a further lamp or camera, or one that is there; the pictures that it changes."""

from dataclasses import dataclass, replace

import jax
import numpy as np

from diffwhitted import layers
from diffwhitted.records import changed
from diffwhitted.scene import AbstractCamera, AbstractLight, DirectionalLight, PointLight, Scene, nearest_name

from .._errors import FitError
from ..problem._nameless import numbered_names
from ..problem._target import CheckedTarget
from ..problem._unknowns import Unknown

ALLOWED = "'light' or 'camera' for a further one, or 'light.NAME' or 'camera.NAME' for one of the scene"


@dataclass(frozen=True)
class Movable:
    """A lamp or a camera of a scene, and the pictures that depend on where it is."""

    scene: Scene
    """With it."""
    family: str
    name: str
    added: bool
    changed: tuple[CheckedTarget, ...]
    others: tuple[CheckedTarget, ...]

    @property
    def record(self) -> AbstractCamera | AbstractLight:
        return self._of(self.scene, self.name)

    @property
    def far(self) -> bool:
        """Is it a direction, with no place?"""
        return isinstance(self.record, DirectionalLight)

    @property
    def place(self) -> np.ndarray | None:
        """Where it stands, (3,)."""
        record = self.record
        return np.asarray(record.look_from, np.float64) if isinstance(record, AbstractCamera) else record.place()

    @property
    def up(self) -> np.ndarray | None:
        """What is up for a camera."""
        return np.asarray(self.record.up, np.float64) if isinstance(self.record, AbstractCamera) else None

    def at(self, place: np.ndarray, middle: np.ndarray, scene: Scene | None = None) -> Scene:
        """The scene with it there; `scene`: as the programs of a problem know it, without names."""
        name = self.name if scene is None else numbered_names(self.scene)[self.family][self.name]
        scene = self.scene if scene is None else scene
        record, place = self._of(scene, name), place.astype(scene.dtype)
        if self.family == "camera":
            moved = changed(record, look_from=place, look_at=middle.astype(scene.dtype))
            return changed(scene, cameras={**scene.cameras, name: moved})
        moved = changed(record, **{"direction" if self.far else "position": place})
        return changed(scene, lights=tuple(moved if light is record else light for light in scene.lights))

    def _of(self, scene: Scene, name: str) -> AbstractCamera | AbstractLight:
        if self.family == "camera":
            return scene.cameras[name]
        return next(light for light in scene.lights if light.name == name)


def movable(
    scene: Scene, targets: tuple[CheckedTarget, ...], what: str, unknowns: tuple[Unknown, ...], taken: bool
) -> Movable:
    """What is to be put somewhere. `taken`: the scene says by its shots what pictures are taken; then a further lamp is
    one of a further shot, by it alone.

    Raises `FitError` for an unknown word or name, for a lamp of another kind, and where its place is free.
    """
    family, _, name = what.partition(".")
    there = {"light": [light.name or "" for light in scene.lights], "camera": list(scene.cameras)}
    if family not in there:
        raise FitError(f"suggest: {what!r}; allowed is {ALLOWED}")
    if name and name not in there[family]:
        raise FitError(
            f"suggest: there is no {family} {name!r}; there is {', '.join(there[family]) or 'none at all'}."
            f"{nearest_name(name, there[family])}"
        )
    if name:
        return _moved(scene, targets, family, name, unknowns)
    name = _new_name(there[family] + [t.name for t in targets])
    return (_with_light if family == "light" else _with_camera)(scene, targets, name, taken)


def _moved(scene: Scene, targets, family: str, name: str, unknowns) -> Movable:
    """A lamp or camera that is there."""
    free = [u.name for u in unknowns if (u.parameter.family, u.parameter.owner) == (family, name) and u.moves]
    if free:
        raise FitError(f"suggest: {free[0]} is free, and a place to be found by a fit cannot be suggested; fix it")
    lamp = next((light for light in scene.lights if family == "light" and light.name == name), None)
    if lamp is not None and not isinstance(lamp, (PointLight, DirectionalLight)):
        raise FitError(f"suggest: light {name!r} is of type {lamp.TYPE!r}; allowed is a point or directional light")

    def seen(target: CheckedTarget) -> bool:
        if family == "camera":
            return target.camera == name
        return target.shot.burns(name)

    mine = tuple(t for t in targets if seen(t))
    if not mine:
        raise FitError(f"suggest: no picture that is planned depends on {family} {name!r}; name another")
    return Movable(scene, family, name, False, mine, tuple(t for t in targets if not seen(t)))


def _with_light(scene: Scene, targets, name: str, taken: bool) -> Movable:
    """One lamp more, like the first: in all pictures, or in a picture of its own."""
    usual = next((light for light in scene.lights if isinstance(light, (PointLight, DirectionalLight))), None)
    lamp = PointLight(np.zeros(3), np.ones(3)) if usual is None else usual
    lamp = changed(jax.tree.map(lambda a: a.astype(scene.dtype), lamp), name=name)
    before = tuple(light.name or "" for light in scene.lights)
    scene = changed(scene, lights=(*scene.lights, lamp))
    if not taken:
        return Movable(scene, "light", name, True, targets, ())
    others = tuple(replace(t, shot=changed(t.shot, lights=before)) if t.shot.lights is None else t for t in targets)
    return Movable(scene, "light", name, True, (_taken_like(targets[0], name, targets[0].camera, (name,)),), others)


def _with_camera(scene: Scene, targets, name: str, taken: bool) -> Movable:
    """One camera more, like that of the first picture, and a picture of its own."""
    first = targets[0]
    scene = changed(scene, cameras={**scene.cameras, name: scene.cameras[first.camera]})
    return Movable(scene, "camera", name, True, (_taken_like(first, name, name, first.shot.lights),), targets)


def _taken_like(first: CheckedTarget, name: str, camera: str, lights: tuple[str, ...] | None) -> CheckedTarget:
    """A further picture, of the size and noise of the first; all of its pixels count."""
    shot = changed(first.shot, name=name, camera=camera, lights=lights, picture=None, mask=None)
    mask = np.ones(first.mask.shape)
    return replace(first, image=np.zeros_like(first.image), camera=camera, mask=mask, shot=shot, file=None)


def _new_name(taken: list[str]) -> str:
    number, name = 2, "suggested"
    while name in taken:
        number, name = number + 1, f"suggested_{number}"
    return name


def surroundings(scene: Scene, cameras: list[AbstractCamera], unknowns: tuple[Unknown, ...]) -> np.ndarray:
    """The middle, (3,), of what these cameras see of the objects that are asked about, or of all."""
    about = {u.parameter.owner for u in unknowns if u.parameter.family in ("material", "object")}
    asked = [thing.name for thing in scene.objects if thing.name in about or thing.material in about]
    points, all_points = [], []
    for camera in cameras:
        seen = layers(scene, camera)
        row, column = np.mgrid[: camera.height, : camera.width] + 0.5
        ray = camera.rays(column.ravel(), row.ravel())
        depth, number = seen.depth.ravel(), seen.object.ravel()
        met = np.isfinite(depth)
        origin, way = (np.asarray(part.stacked(axis=1), np.float64)[met] for part in (ray.origin, ray.direction))
        place = origin + way * depth[met, None]
        mine = np.isin(number[met], [seen.names.index(name) for name in asked])
        points.append(place[mine])
        all_points.append(place)
    found = np.concatenate(points) if any(map(len, points)) else np.concatenate(all_points)
    return np.median(found, axis=0) if len(found) else np.asarray(cameras[0].look_at, np.float64)
