"""The light of patches: what they send of their own and of lamps, what they send to each other, what arrives at points.

B_j = E_j + rho_j sum_k F_jk B_k (Hearn and Baker 14-74, 14-75), E_j = pi emission + what the patch sends back of lamps
and of the background, as the ray tree has it: pi k_d sum c s (N.L). At a point of a surface k_d H / pi is added, with H
the light that arrives there from patches, gathered at the corners of a grid and interpolated between them.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._errors import SceneError
from ..geometry import Departure, Ray, Shapes, blocked
from ..interreflection import Factors, after_shots, solve
from ..numerics._vector import Vec3, dot, lookup, vec3
from ..records import grouped, is_traced, listed, member, member_count
from ._patch_tables import Charts, PatchTables, known_patches
from ._scene import Scene
from .lights import AbstractLight
from .textures import TexturePoint

LAMP_POINTS = 4
"""Of the points of a patch, those that look at a lamp of several members."""
SEEN = 1 - 1e-5
"""Of the way to a lamp."""


class Lightmap(eqx.Module):
    """The light that arrives from patches, by the place of a point on its surface."""

    light: Vec3
    """H / pi at the sites, linear RGB."""
    charts: Charts

    def at(self, primitive: Int[Array, "n"], crossing: Int[Array, "n"], entering, point: Vec3) -> Vec3:
        """H / pi at points of surfaces, bilinear between the sites; differentiable. 0 where nothing was met."""
        charts, surface = self.charts, jnp.maximum(primitive, 0)
        kind = lookup(charts.by_slot, surface)
        chart = jnp.where(entering, lookup(charts.first[0], surface), lookup(charts.first[1], surface))
        there = (primitive >= 0) & (chart >= 0)
        # Find the face, and the place in its space.
        place = point - lookup(charts.middle, surface)
        place = Vec3(*(dot(lookup(row, surface), place) for row in charts.rows))
        sizes = abs(place.x), abs(place.y), abs(place.z)
        largest = jnp.maximum(jnp.maximum(sizes[0], sizes[1]), sizes[2])
        axis = jnp.where(sizes[0] >= largest, 0, jnp.where(sizes[1] >= largest, 1, 2))
        furthest = jnp.where(axis == 0, place.x, jnp.where(axis == 1, place.y, place.z))
        cube = kind == 2
        slot = jnp.where(cube, 2 * axis + (furthest < 0), jnp.where(kind == 1, crossing.astype(jnp.int32), 0))
        place = place * jnp.where(cube & (largest > 0), 1 / jnp.where(largest > 0, largest, 1), 1)
        chart = jnp.where(there, chart + slot, 0)
        # Read off u and v, and the four sites around.
        place = place - lookup(charts.origin, chart)
        u, v = (dot(lookup(way, chart), place) for way in (charts.along, charts.across))
        across, along = (lookup(cells, chart) for cells in charts.cells)
        (i, s), (j, t) = _cell(u, across), _cell(v, along)
        row = along.astype(jnp.int32) + 1
        first = lookup(charts.site, chart) + i * row + j
        right, up = jnp.where(across > 0, row, 0), jnp.where(along > 0, 1, 0)
        corners = (
            (first, (1 - s) * (1 - t)),
            (first + up, (1 - s) * t),
            (first + right, s * (1 - t)),
            (first + right + up, s * t),
        )
        black = jnp.zeros_like(point.x)
        total = Vec3(black, black, black)
        for number, weight in corners:
            total = total + lookup(self.light, number) * jnp.where(there, weight, 0)
        return total


def _cell(place, cells):
    """Which cell of so many, and how far along it."""
    along = jnp.clip(place, 0, 1) * cells
    number = jnp.clip(jnp.floor(jax.lax.stop_gradient(along)), 0, jnp.maximum(cells - 1, 0))
    return number.astype(jnp.int32), along - number


class Solved(eqx.Module):
    """The light of all patches of a scene."""

    tables: PatchTables
    emitted: Float[Array, "n 3"]
    """E: of their own, of lamps and of the background."""
    reflectance: Float[Array, "n 3"]
    radiosity: Float[Array, "n 3"]


def patches_in(scene: Scene, patches: int) -> tuple[Factors, PatchTables]:
    """The patches of a scene. Raises `SceneError` for geometry that is traced or has no patches."""
    return known_patches(scene.placed_objects(), _looking(scene), patches, scene.dtype)


def patches_asked_for(scene: Scene) -> PatchTables | None:
    """Those of a scene with radiosity; None without."""
    return None if scene.radiosity is None else patches_in(scene, scene.radiosity.patches)[1]


def patch_light(scene: Scene, tables: PatchTables, solver: str, shots: int | None = None) -> Solved:
    """Solve for the light of a scene's patches; differentiable in materials and lights.

    `shots`: stop after so many of progressive refinement, the ambient estimate included. Raises `SceneError` for a k_d
    above 1, and for what cannot be seen by patches.
    """
    check_for_patches(scene)
    rho, emission = (_of_patches(scene, tables, name) for name in ("k_d", "emission"))
    return Solved(tables, *_solved(tables, rho, emission, _arriving(scene, tables), solver, shots))


@eqx.filter_jit
def _solved(tables: PatchTables, rho, emission, arriving, solver: str, shots: int | None):
    emitted = jnp.pi * (emission + rho * arriving)
    if shots is None:
        return emitted, rho, solve(tables.matrix, tables.area, rho, emitted, solver)
    return emitted, rho, after_shots(tables.matrix, tables.area, rho, emitted, shots)[1]


def check_for_patches(scene: Scene) -> None:
    """Raise `SceneError` for what light between patches knows nothing of."""
    if scene.distance_fade is not None:
        raise SceneError(
            "scene: distance_fade beside radiosity, whose light does not fade on its way; leave one of them out"
        )
    if moving := next((thing for thing in scene.objects if thing.velocity is not None), None):
        raise SceneError(
            f"object {moving.name!r}: velocity with radiosity, whose patches stand still; leave one of them out"
        )
    for name in {thing.material for thing in scene.objects}:
        material = scene.materials[name]
        k_d = material.values["k_d"]
        if not is_traced(k_d) and k_d is not None and np.max(k_d) > 1:
            raise SceneError(
                f"material {name!r}: k_d = {listed(k_d)} with radiosity; allowed is at most 1, so that no surface "
                "sends back more light than it gets"
            )
        for coefficient, texture in material.textures:
            if coefficient in ("k_d", "emission") and scene.textures[texture].needs_uv:
                raise SceneError(
                    f"material {name!r}: {coefficient}_texture = {texture!r} needs coordinates of its object, which "
                    'patches do not have; write mapping = "planar", "spherical", "cylindrical" or "triplanar" instead'
                )


def _looking(scene: Scene) -> np.ndarray:
    """The places of lamps and cameras, where they are known."""
    places = [camera.look_from for camera in scene.cameras.values()]
    places += [light.place() for light in scene.lights if not any(map(is_traced, jax.tree.leaves(light)))]
    found = [np.asarray(place, np.float64) for place in places if place is not None and not is_traced(place)]
    return np.stack(found) if found else np.zeros((0, 3))


def _of_patches(scene: Scene, tables: PatchTables, name: str) -> Float[Array, "n 3"]:
    """A coefficient of each patch, times the mean of its texture in it."""
    materials = [scene.materials[thing.material] for thing in scene.objects]
    values = [jnp.broadcast_to(jnp.asarray(m.values[name], scene.dtype), 3) for m in materials]
    column = jnp.stack(values)[tables.object]
    worn = [material.texture_at_work(name) for material in materials]
    points, normals = (jax.tree.map(jnp.ravel, v) for v in (tables.points, tables.normals))
    for texture in sorted({one for one in worn if one is not None}):
        record = grouped([scene.textures[texture].tabled()])[0][0].chosen(jnp.zeros(points.x.shape, jnp.int32))
        pattern = record.at(TexturePoint(points, normals)).stacked().reshape(len(column), -1, 3).mean(axis=1)
        wears = jnp.asarray([one == texture for one in worn])[tables.object]
        column = jnp.where(wears[:, None], column * pattern, column)
    return column


def _arriving(scene: Scene, tables: PatchTables) -> Float[Array, "n 3"]:
    """What a white patch sends back of lamps and of the background, as the ray tree has it."""
    total = jnp.zeros((tables.area.shape[0], 3), scene.dtype)
    members = [one for light in scene.lights for one in light.members()]
    for lights in grouped(members)[0] if members else ():
        total = total + _of_lamps(jax.tree.map(jnp.asarray, lights), tables, scene.shadows != "off")
    around = scene.background.surroundings(np.zeros(1, bool))
    if around is not None:
        total = total + jax.tree.map(jnp.asarray, around).mean(tables.normals).stacked().mean(axis=1)
    return total


@eqx.filter_jit
def _of_lamps(lights: AbstractLight, tables: PatchTables, shadows: bool) -> Float[Array, "n 3"]:
    """Of stacked lamps, one after the other."""
    step = 1 if member_count(lights) == 1 else tables.points.x.shape[1] // LAMP_POINTS
    points, normals = (jax.tree.map(lambda a: a[:, ::step], v) for v in (tables.points, tables.normals))
    surface, inwards = (jnp.broadcast_to(a[:, None], points.x.shape) for a in (tables.surface, tables.inwards))

    def one(total, light):
        to_light, distance, colour = light.arriving(points)
        facing = jnp.maximum(dot(normals, to_light), 0) * _within(light, points)
        if shadows and tables.obstacles is not None:
            facing = facing * _unhidden(tables.obstacles, points, to_light, Departure(surface, inwards), distance)
        return total + (colour * facing).stacked().mean(axis=1), None

    total = jnp.zeros((points.x.shape[0], 3), points.x.dtype)
    if member_count(lights) == 1:
        return one(total, member(lights, 0))[0]
    return jax.lax.scan(one, total, lights)[0]


def _unhidden(obstacles: Shapes, points: Vec3, to_light: Vec3, departure: Departure, distance):
    points, to_light, distance = jax.lax.stop_gradient((points, to_light, distance))
    flat = jax.tree.map(jnp.ravel, (points, to_light, departure))
    limit = jnp.broadcast_to(distance, points.x.shape).ravel() * SEEN
    hidden = blocked(obstacles, Ray(flat[0], flat[1]), flat[2], limit, None)  # pyright: ignore[reportArgumentType]
    return (~hidden).reshape(points.x.shape).astype(points.x.dtype)


def _within(light: AbstractLight, points: Vec3):
    """The part of the light that its own edges leave."""
    part = jnp.ones_like(points.x)
    for parallel in light.borders(points):
        outside = 0.0
        for border in parallel:
            lit = (border.value > 0).astype(part.dtype)
            if border.width is not None:
                wide = jnp.maximum(border.width, 0)
                share = jnp.clip(border.value / jnp.where(wide > 0, wide, 1), 0, 1)
                lit = jnp.where(wide > 0, share * share * (3 - 2 * share), lit)
            outside = outside + (1 - lit)
        part = part * jnp.maximum(1 - outside, 0)
    return part


def lightmap(scene: Scene, tables: PatchTables | None) -> Lightmap | None:
    """The light of a scene's patches on its surfaces; None where the scene has no radiosity."""
    if scene.radiosity is None or tables is None:
        return None
    found = patch_light(scene, tables, scene.radiosity.solver)
    return Lightmap(_gathered(tables.gather, found.radiosity), tables.charts)


@eqx.filter_jit
def _gathered(gather, radiosity) -> Vec3:
    return vec3(gather @ radiosity * (1 / jnp.pi))


def brightest_patch(scene: Scene) -> np.ndarray:
    """The most of B / pi of any patch, (3,)."""
    if scene.radiosity is None:
        return np.zeros(3)
    found = patch_light(scene, patches_in(scene, scene.radiosity.patches)[1], scene.radiosity.solver)
    return np.asarray(found.radiosity, np.float64).max(axis=0) / np.pi
