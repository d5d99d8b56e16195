"""Bicubic Bezier patches as rays meet them: found by the triangles of a grid, then polished by Newton's steps."""

from collections.abc import Sequence
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..geometry import AbstractSurfaces, Ray
from ..numerics._safe import normalise, power_of_two, rescaled, safe_divide
from ..numerics._vector import Vec3, cross, dot, vec3, where
from ._triangles import Triangles

CELLS = 16
"""Along each side of a patch; two triangles in each cell are searched."""
STEPS = 5
"""Of Newton's method: from within a cell three suffice."""
BEYOND = 1 / CELLS
"""So far past its sides a patch is continued: its triangles reach past its curved border."""
WEAK = 1e-3
"""A derivative so much shorter than the other one, or a cross product so small, is none."""
INWARDS = 1e-2
"""There the normal is taken so much of the way to the middle of the patch."""

Real = Float[Array, "*n"]


class Patches(AbstractSurfaces):
    """The triangles of grids over patches S(u, v) = sum over i, j of B_i(v) B_j(u) P_ij, each with its whole patch.

    Outwards is dS/du x dS/dv.
    """

    BOUNDED: ClassVar[bool] = True
    DETACHED: ClassVar[bool] = True
    KERNEL: ClassVar[str | None] = "triangle"

    corners: tuple[Vec3, Vec3, Vec3]
    control: Vec3
    """The 16 control points of the patch, row by row, along a trailing axis."""
    places: tuple[tuple[Real, Real], tuple[Real, Real], tuple[Real, Real]]
    """u and v of the corners."""

    @property
    def has_uv(self) -> bool:
        return True

    def crossings(self, ray: Ray, on_it, inwards):
        """Those of the triangle."""
        return Triangles(self.corners).crossings(ray, on_it, inwards)

    def surface(self, ray: Ray, crossing):
        """Distance, outward unit normal and point on the patch, differentiable in ray and control points.

        From where the ray meets the triangle, Newton's steps on S(u, v) - o - t d = 0; the derivatives are those of the
        implicit function. Where they do not end near the triangle, as at an outline, it is the triangle itself.
        """
        del crossing
        far, flat, _, _ = Triangles(self.corners).surface(ray, None)
        u, v, further, good = self._solved(ray, far)
        distance = jnp.where(good, jax.lax.stop_gradient(far) + further, far)
        normal = where(good, self._normal(u, v, flat), flat)
        return distance, normal, ray.at(distance), dot(normal, ray.direction) < 0

    def uv(self, point: Vec3) -> tuple[Real, Real]:
        """u and v of the patch below a point, differentiable; those of the triangle where there are none."""
        triangle = Triangles(self.corners)
        u, v, _, good = self._solved(Ray(point, triangle.normal()), jnp.zeros_like(point.x))
        own = self._between(triangle, point)
        return jnp.where(good, u, own[0]), jnp.where(good, v, own[1])

    @property
    def interpolated(self) -> bool:
        """Rays do not go on from the very point, see `shading`."""
        return True

    def shading(self, ray: Ray, point: Vec3, outward: Vec3) -> tuple[Vec3, Vec3, Vec3]:
        """The normal itself; rays go on from where this one met the triangle if that lies before the patch, so that no
        triangle stands in the light of a hollow.
        """
        far = Triangles(self.corners).surface(ray, None)[0]
        start = where(dot(point - ray.origin, ray.direction) > far, ray.at(far), point)
        return outward, start, start

    def box(self):
        return Triangles(self.corners).box()

    def bounding(self):
        """Middle and radius of a sphere around each triangle."""
        return Triangles(self.corners).bounding()

    def numbers(self):
        return Triangles(self.corners).numbers()

    def _between(self, triangle: Triangles, point: Vec3) -> tuple[Real, Real]:
        """u and v by the shares of a point of the triangle's plane."""
        u, v = jnp.zeros_like(point.x), jnp.zeros_like(point.x)
        for share, (one, other) in zip(triangle.shares(point), self.places, strict=True):
            u, v = u + share * one, v + share * other
        return u, v

    def _solved(self, ray: Ray, far: Real) -> tuple[Real, Real, Real, Bool[Array, "*n"]]:
        """u, v and t - `far` of the crossing near the point at the distance `far`, and whether it was found."""
        still, known, near = jax.lax.stop_gradient((self, ray, far))
        triangle, start = Triangles(still.corners), known.at(near)
        # Count from the start, in units of the triangle.
        sides = [one - other for one, other in zip(still.corners, still.corners[1:], strict=False)]
        largest = jnp.maximum(*(jnp.maximum(jnp.maximum(abs(s.x), abs(s.y)), abs(s.z)) for s in sides))
        unit, way = power_of_two(largest), known.direction
        control = _scaled(still.control, start, unit)

        def closer(_, state):
            u, v, t = state
            du, dv, dt = _step(*_values(control, u, v), way, t)
            return *(jnp.clip(a, -BEYOND, 1 + BEYOND) for a in (u + du, v + dv)), t + dt

        u, v = still._between(triangle, start)
        u, v, t = jax.lax.fori_loop(0, STEPS, closer, (u, v, jnp.zeros_like(u)))
        # Keep what lies on the ray and near the triangle.
        point, along_u, along_v = _values(control, u, v)
        apart = point - way * t
        inside = (abs(u - 0.5) < 0.5 + BEYOND) & (abs(v - 0.5) < 0.5 + BEYOND)
        good = inside & (dot(apart, apart) < 1e-6) & (abs(t) < 4) & (dot(cross(along_u, along_v), way) != 0)
        # Take one step more, with derivatives in its end and none in its slopes.
        moved = _values(_scaled(self.control, start, unit), u, v)[0] - ray.direction * t
        moved = moved - ((ray.origin - known.origin) + (ray.direction - way) * near) * unit
        du, dv, dt = _step(moved + way * t, along_u, along_v, way, t)
        u, v, t = (jnp.where(good, a, 0) for a in (u + du, v + dv, (t + dt) / unit))
        return u, v, t, good

    def _normal(self, u: Real, v: Real, flat: Vec3) -> Vec3:
        """dS/du x dS/dv, of unit length. Edge: where a side of the patch is one point, one derivative vanishes; the
        normal is then that of a place a hundredth of the way to the middle of the patch, or the triangle's.
        """
        normal, weak = _normal_at(self.control, u, v)
        inner = _normal_at(self.control, *(a + INWARDS * (0.5 - a) for a in (u, v)))
        normal = where(weak, inner[0], normal)
        return where(weak & inner[1], flat, normal)


def _scaled(control: Vec3, start: Vec3, unit: Real) -> Vec3:
    """Control points from a start, in other units."""
    return Vec3(*(
        (c - s[..., None]) * unit[..., None]
        for c, s in zip((control.x, control.y, control.z), (start.x, start.y, start.z), strict=True)
    ))  # fmt: skip


def _values(control: Vec3, u: Real, v: Real) -> tuple[Vec3, Vec3, Vec3]:
    """S, dS/du and dS/dv, written out."""
    (across, slope_u), (down, slope_v) = bernstein(u), bernstein(v)

    def each(c) -> tuple[Real, Real, Real]:
        """All four rows at once, then down."""
        c = c.reshape(*c.shape[:-1], 4, 4)
        rows, slopes = (_sum([b[..., None] for b in along], c) for along in (across, slope_u))
        return _sum(down, rows), _sum(down, slopes), _sum(slope_v, rows)

    x, y, z = map(each, (control.x, control.y, control.z))
    return Vec3(x[0], y[0], z[0]), Vec3(x[1], y[1], z[1]), Vec3(x[2], y[2], z[2])


def _sum(weights: Sequence, values) -> Any:
    """Of four values along the last axis."""
    return sum(weight * values[..., k] for k, weight in enumerate(weights))


def bernstein(t: Any) -> tuple[tuple, tuple]:
    """The four cubic polynomials of Bernstein, and their derivatives."""
    s = 1 - t
    slopes = -3 * s * s, 3 * s * (s - 2 * t), 3 * t * (2 * s - t), 3 * t * t
    return (s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t), slopes


def _step(point: Vec3, along_u: Vec3, along_v: Vec3, way: Vec3, t: Real) -> tuple[Real, Real, Real]:
    """Newton's step of u, v and t for S - t d = 0; 0 where there is none."""
    normal, apart = cross(along_u, along_v), point - way * t
    dt = safe_divide(dot(normal, apart), dot(normal, way))
    flat, square = apart - way * dt, dot(normal, normal)
    return (
        -safe_divide(dot(cross(flat, along_v), normal), square),
        -safe_divide(dot(cross(along_u, flat), normal), square),
        dt,
    )


def _normal_at(control: Vec3, u: Real, v: Real) -> tuple[Vec3, Bool[Array, "*n"]]:
    """The unit normal, and whether it is none."""
    first = Vec3(*(c[..., 0] for c in (control.x, control.y, control.z)))
    _, along_u, along_v = _values(_scaled(control, first, jnp.ones_like(u)), u, v)
    (one, by), (other, by_other) = rescaled(along_u), rescaled(along_v)
    short = (by > by_other / WEAK) | (by_other > by / WEAK)
    normal = cross(one, other)
    weak = short | ~(dot(normal, normal) > WEAK * WEAK * dot(one, one) * dot(other, other))
    safe = where(weak, Vec3(jnp.zeros_like(u), jnp.zeros_like(u), jnp.ones_like(u)), normal)
    return normalise(safe), weak


def patches_of(points: Float[Array, "patches 16 3"]) -> Patches:
    """The triangles of a grid over each patch, differentiable."""
    count = points.shape[0]
    at = np.linspace(0, 1, CELLS + 1)
    basis = jnp.asarray(np.stack(bernstein(at)[0], axis=-1), points.dtype)
    grid = jnp.einsum("ai,bj,pijk->pabk", basis, basis, points.reshape(count, 4, 4, 3), precision="highest")
    # A cell is two triangles, counter-clockwise seen from where dS/du x dS/dv points.
    row, column = (a.ravel() for a in np.meshgrid(np.arange(CELLS), np.arange(CELLS), indexing="ij"))
    four = (row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)
    corners, places = [], []
    for number in range(3):
        i, j = (np.concatenate([four[k][axis] for k in ((0, 1, 2)[number], (2, 3, 0)[number])]) for axis in (0, 1))
        corners.append(vec3(grid[:, i, j].reshape(-1, 3)))
        places.append(tuple(jnp.asarray(np.tile(at[k], count), points.dtype) for k in (j, i)))
    each = jnp.repeat(points, 2 * CELLS * CELLS, axis=0, total_repeat_length=2 * CELLS * CELLS * count)
    return Patches((corners[0], corners[1], corners[2]), vec3(each), (places[0], places[1], places[2]))
