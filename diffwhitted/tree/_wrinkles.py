"""Wrinkles: normals bent by a texture of heights (Blinn 1978) or of normals, where a ray arrives.

    N' = (N - grad h) / |...|,   grad h = the slopes of height_scale * texture along the surface

N outwards; for a texture of normals (x, y, z), grad h = -(x T + y B) / z with T along +u and B at right angles to it.
Slopes are softened over the width of the pixel on the surface, that of a cone (Amanatides 1984): it grows as between
camera rays, on from mirror to mirror as if they were flat.
"""

from dataclasses import replace

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..geometry import Ray, Shapes, towards, uv_at
from ..illumination import Bent
from ..numerics._safe import length, normalise
from ..numerics._stage import stage
from ..numerics._vector import Vec3, cross, dot, lookup, tangents, where
from ..records import member_count
from ..scene import AbstractCamera, Tables
from ..scene.textures import AbstractTexture, TexturePoint
from ._arrival import Arrival, Origin
from ._made_of import material_at, place_at_rest
from ._plan import Plan
from ._samples import Samples

FLATTEST = 0.05
"""Cosine below which a grazing ray spreads no further over the surface that it meets."""
Cone = tuple[Float[Array, "n"], Float[Array, "n"]]
"""Width where a ray sets out, metres, and how much more it is for each metre further on."""


def cone_of(
    camera: AbstractCamera, plan: Plan, samples: Samples, parents: Arrival | None, origin: Origin, ray: Ray
) -> Cone | None:
    """The cone of each ray; None where no normals are bent."""
    if not plan.effects.wrinkles:
        return None
    side = samples.side / plan.samples
    width, growth = (apart * side for apart in camera.apart(ray.origin))
    if parents is not None and parents.bent is not None:
        width = jnp.where(origin.lineage == 0, width, parents.bent.width)
    return width, growth


def any_cone(plan: Plan, ray: Ray) -> Cone | None:
    """One that only has a shape."""
    return (ray.origin.x, ray.origin.x) if plan.effects.wrinkles else None


def wrinkled(tables: Tables, at: Arrival, cone: Cone | None, needed) -> Arrival:
    """The arrivals with the normals that light sees, and what is beneath them."""
    if cone is None:
        return at
    shading, bent = stage(needed, lambda at, cone: _bent(tables, at, cone), at, cone)
    return replace(at, shading_normal=shading, bent=bent)


def _bent(tables: Tables, at: Arrival, cone: Cone) -> tuple[Vec3, Bent]:
    """The bent normals on the side of the rays, and what is beneath them."""
    there, material = at.object >= 0, material_at(tables, jnp.maximum(at.object, 0))
    unbent, width = at.shading_normal, cone[0] + cone[1] * at.distance
    outward = where(at.entering, unbent, -unbent)
    # Find the width on the surface, and ask all textures that are worn so how steep they are there.
    wide = width / jnp.maximum(abs(dot(at.direction, unbent)), FLATTEST)
    worn = {key: jnp.where(there, lookup(of, material), -1) for key, of in tables.relief.texture.items()}
    slope = _slope(tables, at, outward, wide, worn, material)
    # Bend the normal, on the side of the ray, and no further than until it grazes the ray.
    new = normalise(outward - slope)
    new = towards(at.direction, where(at.entering, new, -new))
    some = sum(number >= 0 for number in worn.values()) > 0
    new = where(some, new, unbent)
    horizon = jnp.where(some, length(cross(unbent, new)), 0)
    return new, Bent(unbent, horizon, width)


def _slope(
    tables: Tables, at: Arrival, outward: Vec3, width: Float[Array, "n"], worn: dict[str, Int[Array, "n"]], material
) -> Vec3:
    """grad h along the surface; 0 where nothing is worn."""
    one, other = tangents(outward)
    point = TexturePoint(place_at_rest(tables, at), outward, at.uv)
    steps = tuple(_step(tables.shapes, at, step) for step in (one, other))
    zero = jnp.zeros_like(width)
    total, first = Vec3(zero, zero, zero), 0
    for number, group in enumerate(tables.textures):
        for key in (key for key, of in tables.relief.groups if of == number):
            mine = (worn[key] >= first) & (worn[key] < first + member_count(group))
            texture = group.chosen(jnp.where(mine, worn[key] - first, 0))
            rises = _rises(key, texture, point, width, steps)
            if key == "height_texture":
                scale = lookup(tables.coefficients["height_scale"], material)
                rises = tuple(rise * scale for rise in rises)
            total = where(mine, one * rises[0] + other * rises[1], total)
        first += member_count(group)
    return total


def _rises(key: str, texture: AbstractTexture, point: TexturePoint, width, steps):
    if key == "height_texture":
        return texture.slopes(point, width, steps)
    return texture.leanings(point, width, steps)  # pyright: ignore[reportAttributeAccessIssue] an image, as is checked


def _step(shapes: Shapes, at: Arrival, step: Vec3) -> TexturePoint:
    """How what a texture is asked about changes along a unit step on the surface; the normal counts as fixed."""
    zero = jnp.zeros_like(step.x)
    uv = None
    if at.uv is not None:
        uv = jax.jvp(lambda point: uv_at(shapes, at.primitive, point), (at.point,), (step,))[1]
    return TexturePoint(step, Vec3(zero, zero, zero), uv)
