"""Shapes in general positions, and what is known of each by an equation of its own, in NumPy."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.geometry import Ray
from diffwhitted.numerics._vector import vec3

ENDS = dict(base=(-0.2, -0.8, 0.1), top=(0.3, 0.9, -0.2), material="m")
CORNERS = [(x, y, z) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)) for z in (0, 1)]
SIDES = [(2 * k, (2 * k + 2) % 12, (2 * k + 3) % 12, 2 * k + 1) for k in range(6)]
STAIRS = [tuple(range(10, -2, -2)), tuple(range(1, 13, 2)), *SIDES]
"""The faces of a prism over an L."""
THINGS = {
    "disc": dw.Disc("thing", (0.2, 0.1, -0.1), (0.3, 1, 0.2), 0.9, "m"),
    "box": dw.Box("thing", (-1, -0.5, -0.7), (0.6, 0.9, 0.8), "m"),
    "slab": dw.Box("thing", (-1, -0.3, -0.7), (0.6, 0.4, 0.8), "m").placed(
        rotate_deg=(10, 20, 30), scale=(1, 0.7, 1.2)
    ),
    "cylinder": dw.Cylinder("thing", radius=0.6, **ENDS),
    "tube": dw.Cylinder("thing", radius=0.6, capped=False, **ENDS),
    "cone": dw.Cone("thing", base_radius=0.9, top_radius=0, **ENDS),
    "bucket": dw.Cone("thing", base_radius=0.3, top_radius=0.8, **ENDS),
    "funnel": dw.Cone("thing", base_radius=0.3, top_radius=0.8, capped=False, **ENDS),
    "ellipsoid": dw.Quadric("thing", (1, 2, 0.8, 0.3, -0.2, 0.1, 0.1, 0.2, -0.1, -0.8), "m"),
    "hyperboloid": dw.Quadric("thing", (1, -1, 1, 0, 0, 0, 0, 0, 0, -0.3), "m"),
    "hollow": dw.Quadric("thing", (-1, -2, -0.8, 0.3, -0.2, 0.1, 0.1, 0.2, -0.1, 0.8), "m"),
    "saddle": dw.Quadric(
        "thing", (1, -1, 0, 0, 0, 0.2, 0, 0, 0.7, 0), "m", minimum=(-1, -1, -1), maximum=(1, 1, 1)
    ).placed(rotate_deg=(0, 0, 40)),
    "torus": dw.Torus("thing", (0.1, 0, 0.2), (0.2, 1, 0.3), 0.8, 0.3, "m"),
    "hoop": dw.Torus("thing", (0.1, 0, 0.2), (0.2, 1, 0.3), 0.8, 0.02, "m"),
    "prism": dw.Polyhedron("thing", CORNERS, STAIRS, "m").placed(translate=(-1, -0.9, -0.4), rotate_deg=(5, 10, 15)),
}
CLOSED = ("box", "slab", "cylinder", "cone", "bucket", "ellipsoid", "hyperboloid", "hollow", "torus", "hoop", "prism")
OPEN = tuple(name for name in THINGS if name not in CLOSED)


def member(name: str, dtype=jnp.float64):
    """The family of the shape without its leading axis: what a search asks."""
    return jax.tree.map(lambda a: a[0].astype(dtype) if a.dtype.kind == "f" else a[0], THINGS[name].as_placed().alone())


def rays(origins, ways, dtype=jnp.float64) -> Ray:
    return Ray(vec3(jnp.asarray(origins, dtype)), vec3(jnp.asarray(ways, dtype)))


@functools.cache
def asked(name: str):
    """The crossings and the surface of a shape, compiled: of a member, rays, and where they start."""
    del name
    crossings = jax.jit(
        lambda member, ray, on_it, inwards: jnp.stack(member.crossings(ray, on_it, inwards)),
        compiler_options=SOON_COMPILED,
    )
    return crossings, jax.jit(
        lambda member, ray, crossing: member.surface(ray, crossing), compiler_options=SOON_COMPILED
    )


def equation(name: str, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A function that is below 0 inside of what has no end, and one that is below 0 where that is cut off, at points
    (n, 3); of sheets the first one is that of the surface that carries them.
    """
    thing, everywhere = THINGS[name], np.full(len(points), -1.0)
    linear, shift = _pose(thing)
    points = (points - shift) @ np.linalg.inv(linear).T
    match thing:
        case dw.Disc():
            away = points - thing.centre
            normal = np.asarray(thing.normal) / np.linalg.norm(thing.normal)
            return away @ normal, np.linalg.norm(away, axis=1) - float(thing.radius)
        case dw.Box():
            return np.maximum(thing.minimum - points, points - thing.maximum).max(axis=1), everywhere
        case dw.Cylinder() | dw.Cone():
            base, way = np.asarray(thing.base), np.asarray(thing.top) - thing.base
            height = np.linalg.norm(way)
            z = (points - base) @ way / height
            ends = (thing.radius,) * 2 if isinstance(thing, dw.Cylinder) else (thing.base_radius, thing.top_radius)
            away = np.linalg.norm(points - base - z[:, None] * way / height, axis=1)
            side = away - ends[0] - (ends[1] - ends[0]) * z / height
            caps = np.maximum(-z, z - height)
            return (np.maximum(side, caps), everywhere) if thing.capped else (side, caps)
        case dw.Quadric():
            x, y, z = points.T
            terms = (x * x, y * y, z * z, x * y, x * z, y * z, x, y, z, 1 + 0 * x)
            value = np.asarray(thing.coefficients) @ np.stack(terms)
            if thing.minimum is None:
                return value, everywhere
            return value, np.maximum(thing.minimum - points, points - thing.maximum).max(axis=1)
        case dw.Torus():
            axis = np.asarray(thing.axis) / np.linalg.norm(thing.axis)
            away = points - thing.centre
            z = away @ axis
            ring = np.linalg.norm(away - z[:, None] * axis, axis=1) - float(thing.major_radius)
            return np.hypot(ring, z) - float(thing.minor_radius), everywhere
        case dw.Polyhedron():
            # Two boxes make up the L.
            boxes = [np.maximum(-points, points - high).max(axis=1) for high in ((2, 1, 1), (1, 2, 1))]
            return np.minimum(*boxes), everywhere
    raise AssertionError(name)


def _pose(thing) -> tuple[np.ndarray, np.ndarray]:
    """Scale, then rotations one by one, then the shift."""
    linear = np.diag(np.ones(3) * (1.0 if thing.scale is None else np.asarray(thing.scale)))
    for axis, angle in enumerate(np.zeros(3) if thing.rotate_deg is None else np.radians(thing.rotate_deg)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        linear = turn @ linear
    return linear, np.zeros(3) if thing.translate is None else np.asarray(thing.translate)


def met(name: str, origin: np.ndarray, way: np.ndarray, far: float = 9.0, steps: int = 4501) -> list[tuple]:
    """Distances along one ray at which the equation changes its sign, by small steps and halving, and whether it falls
    there.
    """
    reach = np.linspace(1e-9, far, steps)
    value = equation(name, origin + reach[:, None] * way)[0]
    turns = np.flatnonzero((value[1:] > 0) != (value[:-1] > 0))
    low, high, falls = reach[turns], reach[turns + 1], value[turns] > 0
    for _ in range(50):
        middle = 0.5 * (low + high)
        before = (equation(name, origin + middle[:, None] * way)[0] > 0) == falls
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    there = equation(name, origin + low[:, None] * way)[1] <= 0
    return list(zip(low[there].tolist(), falls[there].tolist(), strict=True))


def random_rays(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """From around and from within, towards the middle."""
    random = np.random.default_rng(seed)
    origins = random.normal(size=(count, 3)) * 1.3
    ways = random.normal(size=(count, 3)) * 0.6 - origins
    return origins, ways / np.linalg.norm(ways, axis=1, keepdims=True)
