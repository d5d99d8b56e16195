"""A scene as stacked tables, the form in which the ray tree reads it.

Names stay behind: from here on objects and materials are numbers. Objects are numbered family by
family (see `geometry.Shapes`), materials and textures by name.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..geometry import Planes, Polygons, Shapes, Spheres
from ..numerics._safe import length, normalise, rescaled, safe_divide
from ..numerics._vector import Vec3, vec3
from ._background import Background
from ._lights import Light
from ._objects import Object, Plane, Polygon, Sphere
from ._scene import Scene
from ._textures import Texture


class MaterialTable(eqx.Module):
    """Coefficients as columns over the materials; colours as three columns."""

    k_a: Vec3
    k_d: Vec3
    k_h: Vec3
    k_s: Vec3
    k_t: Vec3
    phong_exponent: Float[Array, "m"]
    refractive_index: Float[Array, "m"]


class Tables(eqx.Module):
    """What the ray tree reads: shapes, coefficients, lights, and who is made of what."""

    shapes: Shapes
    materials: MaterialTable
    material_of: Int[Array, "objects"]
    lights: tuple[Light, ...]
    textures: tuple[Texture, ...]
    background: Background
    ambient: Vec3
    cutoff: Float[Array, ""]
    max_depth: Int[Array, ""] | None = None
    """In place of the plan's, which it does not exceed: a value, so that pictures of every depth share a program."""


def numbered_objects(scene: Scene) -> tuple[Object, ...]:
    """The objects in the order of their numbers in the ray tree."""
    return tuple(o for kind in (Sphere, Plane, Polygon) for o in scene.objects if isinstance(o, kind))


def material_names(scene: Scene) -> list[str]:
    """The materials in the order of their numbers (alphabetical: a pytree does not keep another)."""
    return sorted(scene.materials)


def texture_names(scene: Scene) -> list[str]:
    """The textures in the order of their numbers."""
    return sorted(scene.textures)


def tabulate(scene: Scene) -> Tables:
    """Stack the records of a scene; differentiable."""
    objects = numbered_objects(scene)
    names = material_names(scene)
    shapes = Shapes(
        spheres=_spheres([o for o in objects if isinstance(o, Sphere)]),
        planes=_planes([o for o in objects if isinstance(o, Plane)]),
        polygons=_polygons([o for o in objects if isinstance(o, Polygon)]),
    )
    material_of = jnp.asarray([names.index(o.material) for o in objects], jnp.int32)
    return Tables(
        shapes,
        _materials(scene),
        material_of,
        scene.lights,
        tuple(scene.textures[name] for name in texture_names(scene)),
        scene.background,
        vec3(scene.ambient),
        scene.cutoff,
    )


def _materials(scene: Scene) -> MaterialTable:
    records = [scene.materials[name] for name in material_names(scene)]

    def colours(values):
        return vec3(jnp.stack([jnp.broadcast_to(v, (3,)) for v in values])) if values else None

    def numbers(values):
        return jnp.stack(values) if values else None

    return MaterialTable(
        colours([m.k_a for m in records]),
        colours([m.k_d for m in records]),
        colours([m.highlight_coefficient() for m in records]),
        colours([m.k_s for m in records]),
        colours([m.k_t for m in records]),
        numbers([m.phong_exponent for m in records]),
        numbers([m.refractive_index for m in records]),
    )


def _spheres(spheres: list[Sphere]) -> Spheres | None:
    if not spheres:
        return None
    return Spheres(vec3(jnp.stack([s.centre for s in spheres])), jnp.stack([s.radius for s in spheres]))


def _planes(planes: list[Plane]) -> Planes | None:
    if not planes:
        return None
    normal, power = rescaled(vec3(jnp.stack([p.normal for p in planes])))
    offset = jnp.stack([p.offset for p in planes])
    return Planes(normalise(normal), safe_divide(offset * power, length(normal)))


def _polygons(polygons: list[Polygon]) -> Polygons | None:
    if not polygons:
        return None
    corners = max(p.vertices.shape[0] for p in polygons)
    padded = [jnp.pad(p.vertices, ((0, corners - p.vertices.shape[0]), (0, 0)), mode="edge") for p in polygons]
    return Polygons(vec3(jnp.stack(padded)))
