"""A scene as stacked tables, the form in which the ray tree reads it.

Names stay behind: from here on objects, materials, lights and textures are numbers, and what is true of each of them
is an array, so that pictures of other numbers, names or materials share a compiled program. Objects are numbered kind
by kind in the order of the registry, materials and textures by name.
"""

from collections.abc import Callable, Collection, Sequence
from functools import reduce
from operator import gt, ne, or_

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..geometry import Shapes, Sheets
from ..numerics._vector import Vec3, vec3
from ..records import changed, grouped, is_traced, member_count, stacked
from ..shapes import OBJECTS, SHADING, AbstractObject
from ._coefficients import SWITCHED, coefficients
from ._dispersion import departures
from ._hemisphere import Hemisphere
from ._material import CHOICES, Material, textured_rows
from ._motion import Motion, motion_of
from ._patch_light import Lightmap, lightmap, patches_asked_for
from ._patch_tables import PatchTables
from ._rank import ranked
from ._relief import RELIEFS, Relief
from ._scene import Scene
from ._search import Known, Meeting, known_boxes, meetings_of, shapes_of
from ._sheets import Sheet, sheets_of
from .backgrounds import AbstractBackground, Surroundings
from .lights import AbstractLight
from .textures import AbstractTexture


class Marks(eqx.Module):
    """What cannot be read off the values of a scene where they are traced."""

    wanted: dict[str, Bool[Array, "materials"]]
    """k_s and k_t: a derivative is wanted also where the coefficient is zero, so its rays are followed."""
    glass: Int[Array, "glass"]
    """The materials that may let light through, -1 in the room to spare."""
    solids: tuple[Int[Array, "_"], ...]
    """For each family of shapes, the objects that may be transparent solids, -1 in the room to spare."""
    sheets: Sheets | None = None
    """The surfaces that lie in one place, where that is looked at."""
    patches: PatchTables | None = None
    """Form factors, which are made of known geometry; None without radiosity."""
    boxes: tuple[Known | None, ...] = ()
    """For each family of shapes that is searched by a tree, the tree and the geometry that it was made of."""
    meetings: tuple[Meeting | None, ...] = ()
    """For each family which of its surfaces meet at a side, where rays have footprints."""


class Tables(eqx.Module):
    """What the ray tree reads: shapes, coefficients, lights, and who is made of what."""

    shapes: Shapes
    coefficients: dict[str, Vec3 | Float[Array, "materials"]]
    """By name, columns over the materials; those that may be a colour as three columns. Of `SWITCHED` those that some
    material states.
    """
    material_of: Int[Array, "objects"]
    models: Int[Array, "choices materials"]
    """What each material has chosen, in the order of `CHOICES`: the place of its word among the words there are."""
    texture_of: dict[str, Int[Array, "materials"]]
    """For each coefficient that has a texture somewhere: the number of the texture, -1 for none."""
    textures: tuple[AbstractTexture, ...]
    """Stacked, those of one structure in one record, numbered through."""
    lights: tuple[AbstractLight, ...]
    """In the same way."""
    background: AbstractBackground
    surroundings: Surroundings | None
    """How the background lights surfaces; None where it does not."""
    ambient: Vec3 | Hemisphere
    lightmap: Lightmap | None
    """Light between diffuse surfaces; None where the scene has none."""
    distance_fade: Float[Array, "2"] | None
    cutoff: Float[Array, ""]
    mirrors: Bool[Array, "materials"]
    """Does the material send mirror rays?"""
    transparent: Bool[Array, "materials"]
    """Does it let light through, or is a derivative wanted for which its rays are followed?"""
    clear: Bool[Array, "materials"]
    """Does it let light through as it is? What does not is no medium and reflects nothing totally."""
    glass_of: Int[Array, "surfaces"]
    """The place in `marks.glass` of the material of each surface, -1 for none."""
    shading: Int[Array, "objects"] | None
    """How light is interpolated over each object, the place of its word in `SHADING`; None where no object has corners.
    """
    rank: Int[Array, "objects"]
    """The order of the objects by their size, smallest first: where solids overlap, the first one counts."""
    marks: Marks
    departures: Float[Array, "materials bands"] | None = None
    """By how much the index of each material departs from that of the line d in each band; None: nowhere."""
    seed: Int[Array, ""] | None = None
    """Of what is left to chance."""
    motion: Motion | None = None
    """Of the objects; None where none moves."""
    shift: Vec3 | None = None
    """How far each object has moved from where it is stated (see `tree._motion`); None: not at all."""
    relief: Relief | None = None
    """What bends normals; None where nothing does."""
    max_depth: Int[Array, ""] | None = None
    """In place of the plan's, which it does not exceed: a value, so that pictures of every depth share a program."""


def numbered_objects(scene: Scene) -> tuple[AbstractObject, ...]:
    """The objects in the order of their numbers in the ray tree, where their transforms have taken them."""
    placed = scene.placed_objects()
    return tuple(thing for kind in OBJECTS for thing in placed if type(thing) is kind)


def material_names(scene: Scene) -> list[str]:
    """The materials in the order of their numbers (alphabetical: a pytree does not keep another)."""
    return sorted(scene.materials)


def texture_names(scene: Scene) -> list[str]:
    """The textures in the order of their numbers within the scene."""
    return sorted(scene.textures)


def tabulate(scene: Scene, marks: Marks | None = None) -> Tables:
    """Stack the records of a scene; differentiable.

    `marks`: those of `marks_of` (by default, of this very scene), for a scene whose values are traced but were known.
    """
    marks = marks_of(scene) if marks is None else marks
    objects, names = numbered_objects(scene), material_names(scene)
    materials = [scene.materials[name] for name in names]
    # Stack the coefficients, and find which texture multiplies which of them.
    rows = [row for row in coefficients() if row.name not in SWITCHED or any(row.name in m.switched for m in materials)]
    values = [m.all_at_work() for m in materials]
    table = {row.name: _column([held[row.name] for held in values], row.coloured) for row in rows}
    textures, texture_number = grouped([scene.textures[name].tabled() for name in texture_names(scene)])
    number_of = dict(zip(texture_names(scene), texture_number.tolist(), strict=True))
    texture_of = {}
    for row in textured_rows() if textures else ():
        worn = [m.texture_at_work(row.name) for m in materials]
        if any(worn):
            texture_of[row.name] = jnp.asarray([-1 if w is None else number_of[w] for w in worn], jnp.int32)
    # Number the materials, and order the objects by size.
    index_of = {name: number for number, name in enumerate(names)}
    material_of = np.asarray([index_of[thing.material] for thing in objects], np.int32)
    glass = jnp.arange(marks.glass.shape[0], dtype=jnp.int32)
    place_in_glass = jnp.full(len(names) + 1, -1, jnp.int32).at[marks.glass].set(glass).at[-1].set(-1)
    shapes = shapes_of(objects, marks.boxes, marks.sheets, marks.meetings)
    return Tables(
        shapes=shapes,
        coefficients=table,
        material_of=jnp.asarray(material_of),
        models=jnp.asarray(
            [[words.index(choice(m)) for m in materials] for words, choice in CHOICES.values()], jnp.int32
        ),
        texture_of=texture_of,
        textures=textures,
        lights=tabled_lights(scene)[0],
        background=jax.tree.map(jnp.asarray, scene.background.tabled()),
        surroundings=jax.tree.map(
            jnp.asarray, scene.background.surroundings(np.asarray([m.is_shiny for m in materials], bool))
        ),
        ambient=_ambient(scene),
        lightmap=lightmap(scene, marks.patches),
        distance_fade=None if scene.distance_fade is None else jnp.asarray(scene.distance_fade),
        cutoff=jnp.asarray(scene.cutoff),
        mirrors=marks.wanted["k_s"] | _some(table["k_s"]),
        transparent=marks.wanted["k_t"] | _some(table["k_t"]),
        clear=_some(table["k_t"], gt),
        glass_of=shapes.by_surface(place_in_glass[material_of]),
        shading=_shading(objects),
        rank=ranked(objects),
        marks=changed(marks, boxes=(), meetings=(), patches=None),
        departures=_departures(scene, materials),
        seed=jnp.int32(scene.seed),
        motion=motion_of(objects, scene.dtype),
        relief=_relief(materials, number_of, textures),
    )


def _relief(materials: Sequence[Material], number_of: dict[str, int], textures) -> Relief | None:
    """`number_of`: the numbers of textures by name; `textures`: the groups in which they are stacked."""
    worn = {key: [dict(m.relief if m.is_wrinkled else ()).get(key) for m in materials] for key in RELIEFS}
    numbers = {
        key: np.asarray([-1 if name is None else number_of[name] for name in names], np.int32)
        for key, names in worn.items()
        if any(names)
    }
    if not numbers:
        return None
    ends = np.cumsum([member_count(group) for group in textures])
    groups = {(key, int(group)) for key, of in numbers.items() for group in np.searchsorted(ends, of[of >= 0], "right")}
    return Relief({key: jnp.asarray(of) for key, of in numbers.items()}, tuple(sorted(groups)))


def _shading(objects: Sequence[AbstractObject]):
    if not any(type(thing).INTERPOLATES for thing in objects):
        return None
    return jnp.asarray([SHADING.index(thing.interpolation or "phong") for thing in objects], jnp.int32)


def _departures(scene: Scene, materials: Sequence[Material]):
    if all(material.curve is None for material in materials):
        return None
    return jnp.asarray(np.stack([departures(material.curve, scene.bands) for material in materials]), scene.dtype)


def marks_of(
    scene: Scene,
    free: Collection[str] = (),
    where_traced: bool = True,
    shared: Sequence[Sheet] = (),
    searched: bool = True,
    outlines: bool = False,
) -> Marks:
    """The marks of a scene whose values are known, or as far as they are: what is traced may be anything.

    `free`: names of coefficients ("glass.k_s") whose derivative is wanted although they may be zero; `where_traced`:
    that of all traced ones is; `shared`: the surfaces in one place (see `shared_sheets`); `searched`: the trees of
    boxes too, for a scene that will be traced with other numbers or the same; `outlines`: rays will have footprints.
    """
    names, objects = material_names(scene), numbered_objects(scene)

    def wanted(coefficient: str):
        return jnp.asarray([
            f"{name}.{coefficient}" in free
            or (where_traced and is_traced(scene.materials[name].values[coefficient]))
            for name in names
        ], bool)  # fmt: skip

    clear = [
        f"{name}.k_t" in free
        or is_traced(k_t := scene.materials[name].values["k_t"])
        or bool(np.any(np.asarray(k_t) > 0))
        for name in names
    ]
    solids, first, clear_names = [], 0, {name for name, some in zip(names, clear, strict=True) if some}
    for kind in OBJECTS:
        mine = [thing for thing in objects if type(thing) is kind]
        if mine:
            found = [first + k for k, o in enumerate(mine) if o.material in clear_names and o.solid]
            solids.append(_with_room(found))
            first += len(mine)
    return Marks(
        {"k_s": wanted("k_s"), "k_t": wanted("k_t")},
        _with_room(np.flatnonzero(clear)),
        tuple(solids),
        patches=patches_asked_for(scene),
        boxes=known_boxes(objects) if searched else (),
        meetings=meetings_of(objects, searched) if outlines else (),
        sheets=sheets_of(objects, shared, {thing.name for thing in objects if thing.material in clear_names}),
    )


def tabled_lights(scene: Scene) -> tuple[tuple[AbstractLight, ...], list[int], np.ndarray]:
    """The lights stacked, those of one structure in one record; for each of them the number of the light of the scene
    that it is part of, and its place in the order of the groups.
    """
    members = [(number, one) for number, light in enumerate(scene.lights) for one in light.members()]
    groups, order = grouped([one for _, one in members])
    return groups, [number for number, _ in members], order


def _ambient(scene: Scene) -> Vec3 | Hemisphere:
    ambient = jax.tree.map(jnp.asarray, scene.ambient)
    return ambient if isinstance(ambient, Hemisphere) else vec3(ambient)


def _column(values: list, coloured: bool):
    """One value a material, as a column or, of a colour, three."""
    if not coloured:
        return stacked(values)
    if not values:
        return vec3(jnp.zeros((0, 3)))

    def three(value):
        if np.ndim(value):
            return value
        return jnp.broadcast_to(value, (3,)) if is_traced(value) else np.broadcast_to(value, 3)

    if any(map(is_traced, values)):
        return vec3(stacked(list(map(three, values))))
    # Taken apart on the host: an array of JAX takes long to slice.
    return Vec3(*map(jnp.asarray, np.stack([np.asarray(three(value)) for value in values], axis=1)))


def _some(coefficient: Vec3 | Float[Array, "materials"], than: Callable = ne) -> Bool[Array, "materials"]:
    """Is any channel other than zero, or greater (`gt`)?"""
    channels = (coefficient.x, coefficient.y, coefficient.z) if isinstance(coefficient, Vec3) else (coefficient,)
    return reduce(or_, (than(channel, 0) for channel in channels))


def _with_room(numbers) -> Int[Array, "room"]:
    """Whole numbers with room for the next power of two, -1 in what is left; none for none."""
    room = 1 << max(len(numbers) - 1, 0).bit_length() if len(numbers) else 0
    return jnp.asarray([*numbers, *[-1] * (room - len(numbers))], jnp.int32)
