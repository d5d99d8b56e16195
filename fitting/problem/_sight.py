"""What one shot sees of a scene: which camera took it, which lamps burn, and on which unknowns it depends.

All of it is a value and not part of a program: the shots of one camera under a lamp each, or of many cameras of one
size, share their compiled programs.
"""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from diffwhitted.records import changed, grouped, member
from diffwhitted.scene import Camera, Marks, Scene, Shot, Tables, tabled_lights, tabulate

from ._unknowns import Unknown

NOBODY = 2**30
"""In the place of an unknown, where a shot depends on fewer than others do."""


class Sight(eqx.Module):
    """Of one target."""

    camera: Int[Array, ""]
    """Its place among the cameras of its kind."""
    shot: Int[Array, ""]
    """Its place among the shots of its kind."""
    burning: tuple[Int[Array, "m"], ...]
    """For each kind of light that burns: the places of those that do among the lights of the kind."""
    free: Int[Array, "m"]
    """The unknowns of the scene on which its light depends, by number; `NOBODY` in the room to spare."""
    free_shot: Int[Array, "s"]
    """Those of the shots."""
    cameras: tuple[str, ...] = eqx.field(static=True)
    """All cameras of its kind: of one size and structure."""
    shots: tuple[int, ...] = eqx.field(static=True)
    """All shots of its kind, by number."""
    kinds: tuple[int, ...] = eqx.field(static=True)
    """The kinds of light that burn, by number."""

    def camera_of(self, scene: Scene) -> Camera:
        """The camera of a scene whose camera numbers are free."""
        return _picked([scene.cameras[name] for name in self.cameras], self.camera)

    def shot_of(self, scene: Scene) -> Shot:
        return _picked([scene.shots[number] for number in self.shots], self.shot)

    def tables_of(self, scene: Scene, marks: Marks) -> Tables:
        """The tables of the scene, with those lights alone that burn."""
        tables = tabulate(scene, marks)
        lights = tuple(
            jax.tree.map(lambda column, chosen=chosen: column[chosen], tables.lights[kind])
            for kind, chosen in zip(self.kinds, self.burning, strict=True)
        )
        return changed(tables, lights=lights)


def sights(
    scene: Scene, cameras: Sequence[str], burning: Sequence[Sequence[str] | None], unknowns: tuple[Unknown, ...]
) -> tuple[Sight, ...]:
    """What each shot of a scene sees: the names of its camera and of the lights that burn (None: all)."""
    lights, owners, order = tabled_lights(scene)
    sizes = [jax.tree.leaves(kind)[0].shape[0] for kind in lights]
    first = np.cumsum([0, *sizes])
    camera_kinds, shot_kinds = _kinds(list(scene.cameras.values())), _kinds(scene.shots)
    camera_names = list(scene.cameras)
    depends = [
        _depends(unknowns, camera, names, shot.name)
        for camera, names, shot in zip(cameras, burning, scene.shots, strict=True)
    ]
    rooms = [max(len(found[k]) for found in depends) for k in (0, 1)]
    made = []
    for number, (camera, names) in enumerate(zip(cameras, burning, strict=True)):
        burns = [names is None or light.name in names for light in scene.lights]
        places = [place for place, owner in zip(order, owners, strict=True) if burns[owner]]
        chosen = [np.sort([p - first[k] for p in places if first[k] <= p < first[k + 1]]) for k in range(len(lights))]
        kinds = tuple(k for k, mine in enumerate(chosen) if len(mine))
        cameras_like, place = _alike(camera_kinds, camera_names.index(camera))
        shots_like, shot_place = _alike(shot_kinds, number)
        free, free_shot = (
            jnp.asarray(mine + [NOBODY] * (room - len(mine)), jnp.int32)
            for mine, room in zip(depends[number], rooms, strict=True)
        )
        made.append(
            Sight(
                camera=jnp.int32(place),
                shot=jnp.int32(shot_place),
                burning=tuple(jnp.asarray(chosen[k], jnp.int32) for k in kinds),
                free=free,
                free_shot=free_shot,
                cameras=tuple(camera_names[k] for k in cameras_like),
                shots=tuple(shots_like),
                kinds=kinds,
            )
        )
    return tuple(made)


def of_shots(unknowns: tuple[Unknown, ...], really: bool = True) -> list[int]:
    """The numbers of the unknowns that say how a shot shows light, or of all others."""
    return [i for i, u in enumerate(unknowns) if (u.parameter.family == "shot") is really]


def _depends(unknowns: tuple[Unknown, ...], camera: str, names, shot: str) -> tuple[list[int], list[int]]:
    """The unknowns on which what this camera sees by these lights may depend, by their number among those of the scene,
    and those of the shot, by their number among those of shots.
    """
    of_scene = [unknowns[i] for i in of_shots(unknowns, False)]
    mine = [unknowns[i] for i in of_shots(unknowns)]

    def seen(unknown: Unknown) -> bool:
        owner, family = unknown.parameter.owner, unknown.parameter.family
        return not (
            (family == "camera" and owner != camera) or (family == "light" and names is not None and owner not in names)
        )

    return [i for i, u in enumerate(of_scene) if seen(u)], [i for i, u in enumerate(mine) if u.parameter.owner == shot]


def _kinds(records: Sequence) -> list[list[int]]:
    """The numbers of the records of one structure, kind by kind."""
    kinds: dict = {}
    for number, record in enumerate(records):
        leaves, structure = jax.tree.flatten(_nameless(record))
        kinds.setdefault((structure, tuple(np.shape(leaf) for leaf in leaves)), []).append(number)
    return list(kinds.values())


def _nameless(record):
    return changed(record, name="") if isinstance(record, Shot) else record


def _alike(kinds: list[list[int]], number: int) -> tuple[list[int], int]:
    """All records of its kind, and its place among them."""
    mine = next(kind for kind in kinds if number in kind)
    return mine, mine.index(number)


def _picked(records: Sequence, place: Int[Array, ""]):
    """One of several records of a kind; the only one as it is."""
    if len(records) == 1:
        return records[0]
    groups, _ = grouped(records)
    return member(groups[0], place)
