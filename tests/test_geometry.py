"""Where rays meet spheres, planes and polygons, against algebra and the figures of a book."""

import json
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.geometry import (
    NOTHING,
    Departure,
    Footprint,
    Ray,
    Shapes,
    blocked,
    containing,
    crossing_counts,
    nearest,
    nearest_part,
    surface_at,
)
from diffwhitted.numerics._vector import dot, vec3
from diffwhitted.shapes import Planes, Polygons, Spheres

BOOK = json.loads((Path(__file__).parent / "oracles" / "ray_tracer_challenge.json").read_text())["geometry"]
BOTH = ("float32", "float64")


def spheres(*centres_and_radii, dtype="float64"):
    rows = np.asarray(centres_and_radii, dtype)
    return Spheres(vec3(jnp.asarray(rows[:, :3])), jnp.asarray(rows[:, 3]))


def planes(*normals_and_offsets, dtype="float64"):
    rows = np.asarray(normals_and_offsets, dtype)
    return Planes(vec3(jnp.asarray(rows[:, :3])), jnp.asarray(rows[:, 3]))


def polygons(*outlines, dtype="float64"):
    return Polygons(vec3(jnp.asarray(np.asarray(outlines, dtype))))


def rays(origins, directions, dtype="float64"):
    origins, directions = np.broadcast_arrays(
        np.atleast_2d(np.asarray(origins, float)), np.atleast_2d(np.asarray(directions, float))
    )
    directions = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    return Ray(vec3(jnp.asarray(origins, dtype)), vec3(jnp.asarray(directions, dtype)))


def in_free_space(ray):
    return Departure(jnp.full(ray.origin.shape, NOTHING, jnp.int32), jnp.zeros(ray.origin.shape, bool))


def leaving(ray, object, inwards):
    return Departure(
        jnp.full(ray.origin.shape, object, jnp.int32), jnp.broadcast_to(jnp.asarray(inwards), ray.origin.shape)
    )


@jax.jit
def first_hit(shapes, ray, departure):
    """The nearest surface, and its hit record."""
    distance, primitive, crossing = nearest(shapes, ray, departure)
    return distance, surface_at(shapes, ray, primitive, crossing)


def crossings_ahead(family, ray):
    """All distances at which one ray crosses the shapes of a family, in order."""
    found = []
    for i in range(family.count):
        one = jax.tree.map(lambda a: a[i], family)  # noqa: B023
        found += [float(d[0]) for d in one.crossings(ray, jnp.zeros(1, bool), jnp.zeros(1, bool))]
    return sorted(d for d in found if np.isfinite(d))


# The figures of a book


@pytest.mark.parametrize("case", BOOK["sphere_hits_unit_sphere"], ids=lambda c: f"from {c['origin']}")
def test_unit_sphere_of_the_book(case):
    """The book lists crossings behind the ray too, and a tangent ray twice; here a ray meets what it enters or leaves
    ahead.
    """
    ray = rays(case["origin"], case["direction"])
    tangent = len(set(case["t"])) < len(case["t"])
    expected = [] if tangent else [t for t in case["t"] if t > 0]
    assert crossings_ahead(spheres((0, 0, 0, 1)), ray) == pytest.approx(expected, abs=1e-12)


def test_other_spheres_of_the_book():
    world, scaled = BOOK["default_world_hits"], BOOK["scaled_sphere"]
    both = spheres((0, 0, 0, 1), (0, 0, 0, 0.5))
    assert crossings_ahead(both, rays(world["origin"], world["direction"])) == pytest.approx(world["t"], abs=1e-12)
    one = spheres((0, 0, 0, scaled["radius"]))
    assert crossings_ahead(one, rays(scaled["origin"], scaled["direction"])) == pytest.approx(scaled["t"], abs=1e-12)


@pytest.mark.parametrize("case", BOOK["plane_y0"], ids=lambda c: f"from {c['origin']}")
def test_plane_of_the_book(case):
    assert crossings_ahead(planes((0, 1, 0, 0)), rays(case["origin"], case["direction"])) == pytest.approx(case["t"])


def test_triangle_of_the_book():
    """The book's normal comes from the other order of the vertices: it points the other way."""
    case = BOOK["triangle"]
    triangle = polygons([case["p1"], case["p2"], case["p3"]])
    hit = case["hit"]
    assert crossings_ahead(triangle, rays(hit["origin"], hit["direction"])) == pytest.approx([hit["t"]])
    for miss in case["misses"]:
        assert crossings_ahead(triangle, rays(miss["origin"], miss["direction"])) == []
    normal = triangle.carrier().normal.stacked()[0]
    np.testing.assert_allclose(-normal, case["normal"], atol=1e-15)


def test_shadows_of_the_book():
    points = np.array([c["point"] for c in BOOK["shadow_default_world"]], float)
    way = np.array([-10, 10, -10]) - points
    ray, shapes = rays(points, way), Shapes((spheres((0, 0, 0, 1), (0, 0, 0, 0.5)),))
    found = blocked(shapes, ray, in_free_space(ray), jnp.linalg.norm(way, axis=-1), (True, True))
    assert found.tolist() == [c["shadowed"] for c in BOOK["shadow_default_world"]]


# Spheres


@pytest.mark.parametrize("dtype", BOTH)
def test_tiny_sphere_far_away(dtype):
    """Radius 1e-4 at distance 1e4: equation 14-58 keeps the normal, which the quadratic formula loses altogether."""
    radius, far, aside = 1e-4, 1e4, np.array([0.0, 0.3e-4, -0.9e-4, 0.999e-4, 1.001e-4])
    ray = rays(np.stack([aside, 0 * aside, 0 * aside], axis=1), (0, 0, -1), dtype)
    distance, hit = first_hit(Shapes((spheres((0, 0, -far, radius), dtype=dtype),)), ray, in_free_space(ray))
    assert hit.object.tolist() == [0, 0, 0, 0, -1]
    across = aside[:4] / radius
    height = np.sqrt(1 - across**2)
    eps = float(jnp.finfo(dtype).eps)
    np.testing.assert_allclose(
        hit.normal.stacked()[:4], np.stack([across, 0 * across, height], axis=1), atol=2000 * eps
    )
    np.testing.assert_allclose(distance[:4], far - radius * height, rtol=2 * eps)
    np.testing.assert_allclose(hit.point.x[:4], aside[:4], atol=1e-3 * radius)


@pytest.mark.parametrize("dtype", BOTH)
def test_sphere_from_outside_and_from_inside(dtype):
    shapes = Shapes((spheres((1, 2, 3, 2), dtype=dtype),))
    ray = rays([(1, 2, 9), (1, 2, 3.5), (1, 3.2, 3)], [(0, 0, -1), (0, 0, -1), (0, 0, 1)], dtype)
    distance, hit = first_hit(shapes, ray, in_free_space(ray))
    np.testing.assert_allclose(distance, [4, 2.5, 1.6], rtol=1e-6)
    assert hit.entering.tolist() == [True, False, False]
    np.testing.assert_allclose(hit.normal.stacked(), [(0, 0, 1), (0, 0, 1), (0, -0.6, -0.8)], atol=1e-6)
    np.testing.assert_allclose(hit.point.stacked(), [(1, 2, 5), (1, 2, 1), (1, 3.2, 4.6)], rtol=1e-6)
    np.testing.assert_allclose(-dot(hit.normal, ray.direction), [1, 1, 0.8], rtol=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 1, 1e4])
@pytest.mark.parametrize("dtype", BOTH)
def test_no_ray_meets_the_surface_it_leaves(dtype, scale):
    """Outwards from a sphere nothing is met; inwards the far side, at the chord -2 r (u.N); at any scale.

    A short chord is a root of a small difference: its error is some roundings of r**2 over the chord.
    """
    random = np.random.default_rng(1)
    normal, way = random.normal(size=(2, 500, 3))
    normal, way = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (normal, way))
    centre = np.array([3.0, -2.0, 5.0]) * scale
    ray = rays(centre + 0.7 * scale * normal, way, dtype)
    outwards = (normal * way).sum(axis=-1) > 0
    shapes = Shapes((spheres((*centre, 0.7 * scale), dtype=dtype),))
    distance, hit = first_hit(shapes, ray, leaving(ray, 0, ~outwards))
    assert hit.object.tolist() == np.where(outwards, NOTHING, 0).tolist()
    assert not hit.entering.any()
    chord = -2 * 0.7 * scale * (normal * way).sum(axis=-1)
    rounding = 4 * float(jnp.finfo(dtype).eps) * np.linalg.norm(centre)
    assert (np.abs(distance - chord) < rounding * (1 + scale / chord))[~outwards].all()


def test_no_ray_meets_the_plane_or_polygon_it_leaves():
    shapes = Shapes((planes((0, 1, 0, -1)), polygons([(-1, 0, -1), (0, 0, 1), (1, 0, -1)])))
    below = rays([(0.3, -1 + 1e-17, 0.2), (0.0, 1e-17, 0.0)], (0.1, -1, 0.1))
    on_plane, on_polygon = (jax.tree.map(lambda a: a[i : i + 1], below) for i in range(2))  # noqa: B023
    assert first_hit(shapes, on_plane, leaving(on_plane, 0, True))[1].object.tolist() == [NOTHING]
    assert first_hit(shapes, on_polygon, leaving(on_polygon, 1, False))[1].object.tolist() == [0]


# Polygons

ARROW = [(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)]


def inside_arrow(x, y):
    """A square with a triangle taken out of its upper side, whose point is at (2, 1)."""
    return (0 < x) & (x < 4) & (y > 0) & (y < np.where(x < 2, 4 - 1.5 * x, 1 + 1.5 * (x - 2)))


@pytest.mark.parametrize("turn", [(0, 1, 2), (1, 2, 0), (2, 0, 1)], ids=["xy", "yz", "zx"])
def test_concave_polygon(turn):
    """A grid of rays through a polygon with a notch, in each of the coordinate planes."""
    across, up = (g.reshape(-1) + 0.03125 for g in np.meshgrid(np.linspace(-1, 5, 25), np.linspace(-1, 5, 25)))

    def placed(x, y, z):
        return np.stack(np.broadcast_arrays(x, y, z), axis=-1)[..., np.argsort(turn)]

    shapes = Shapes((polygons(placed(*np.array(ARROW, float).T, 0.5)),))
    ray = rays(placed(across, up, 3.0), placed(0.0, 0.0, -1.0))
    distance, hit = first_hit(shapes, ray, in_free_space(ray))
    expected = inside_arrow(across, up)
    assert 100 < expected.sum() < 300
    assert (hit.object >= 0).tolist() == expected.tolist() and hit.entering.tolist() == expected.tolist()
    np.testing.assert_allclose(distance[expected], 2.5)
    np.testing.assert_allclose(
        hit.normal.stacked()[expected], np.broadcast_to(placed(0.0, 0.0, 1.0), (expected.sum(), 3))
    )


def test_polygon_from_behind_and_edge_on():
    square = polygons([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    ray = rays([(0.5, 0.5, -2), (-1, 0.5, 0), (0.5, 0.5, 0)], [(0, 0, 1), (1, 0, 0), (0, 1, 0)])
    distance, hit = first_hit(Shapes((square,)), ray, in_free_space(ray))
    assert hit.object.tolist() == [0, NOTHING, NOTHING] and not hit.entering[0]
    assert distance[0] == 2 and hit.normal.stacked()[0].tolist() == [0, 0, -1]
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(hit))


def test_polygon_padded_by_its_last_vertex():
    """A triangle stored beside a longer polygon repeats its last vertex: edges without length change nothing."""
    triangle = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    random = np.random.default_rng(2).uniform(-0.5, 1.5, size=(200, 2))
    ray = rays(np.column_stack([random, np.ones(200)]), (0, 0, -1))
    short, long = (
        first_hit(Shapes((polygons(p),)), ray, in_free_space(ray))[1] for p in (triangle, triangle + triangle[-1:] * 2)
    )
    assert (
        short.object.tolist()
        == long.object.tolist()
        == np.where((random > 0).all(1) & (random.sum(1) < 1), 0, NOTHING).tolist()
    )
    assert short.normal.stacked().tolist() == long.normal.stacked().tolist()


def test_two_triangles_that_share_an_edge_leave_no_gap():
    """Rays through the diagonal of a square meet exactly one of its two halves."""
    halves = polygons([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (0, 1, 0)])
    along = np.arange(1, 32) / 32
    ray = rays(np.stack([along, along, 0 * along + 1], axis=1), (0, 0, -1))
    (count,) = crossing_counts(Shapes((halves,)), ray, in_free_space(ray), jnp.inf, jnp.asarray([0, 0]), 1)
    assert count.tolist() == [1] * 31


# Many shapes


def test_search_over_many_equals_search_by_hand():
    """More shapes than are unrolled: the loop finds the same as a minimum over all distances."""
    random = np.random.default_rng(3)
    rows = np.column_stack([random.uniform(-3, 3, size=(20, 3)), random.uniform(0.2, 0.8, size=20)])
    origins, ways = random.uniform(-5, 5, size=(300, 3)), random.normal(size=(300, 3))
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    ray = rays(origins, ways)
    distance, hit = first_hit(Shapes((spheres(*rows), planes((0, 0, 1, -4)))), ray, in_free_space(ray))

    to_centre = rows[None, :, :3] - origins[:, None]
    b = (to_centre * ways[:, None]).sum(-1)
    c = (to_centre**2).sum(-1) - rows[:, 3] ** 2
    root = np.sqrt(np.maximum(b * b - c, 0))
    both = np.where((b * b > c)[..., None], np.stack([b - root, b + root], axis=-1), np.inf)
    ahead = np.where(both > 0, both, np.inf).min(axis=-1)
    to_plane = (-4 - origins[:, 2]) / ways[:, 2]
    all_ = np.column_stack([ahead, np.where(to_plane > 0, to_plane, np.inf)])
    nearest_of_all = all_.min(axis=1)
    met = np.isfinite(nearest_of_all)
    assert hit.object.tolist() == np.where(met, all_.argmin(axis=1), NOTHING).tolist() and 0 < (~met).sum() < 200
    np.testing.assert_allclose(distance, nearest_of_all, rtol=1e-9)


def test_crossings_are_counted_up_to_the_limit_for_chosen_objects():
    shapes = Shapes((spheres((0, 0, 2, 1), (0, 0, 6, 1)), planes((0, 0, 1, 9))))
    ray = rays([(0, 0, 0)] * 5, (0, 0, 1))
    limit = jnp.asarray([0.5, 2.0, 4.0, 6.0, jnp.inf])
    free = in_free_space(ray)
    (all_,) = crossing_counts(shapes, ray, free, limit, jnp.asarray([0, 0, 0]), 1)
    others, second = crossing_counts(shapes, ray, free, limit, jnp.asarray([0, 1, -1]), 2)
    assert all_.tolist() == [0, 1, 2, 3, 5]
    assert others.tolist() == [0, 1, 2, 2, 2] and second.tolist() == [0, 0, 0, 1, 2]
    blocks = jnp.asarray([False, True, False])
    assert blocked(shapes, ray, free, limit, blocks).tolist() == [False, False, False, True, True]
    assert blocked(shapes, ray, free, limit, None).tolist() == [False, True, True, True, True]


def test_the_solid_around_a_point():
    """Of nested solids the one of the lowest rank that holds the point; a plane holds what its normal points away
    from.
    """
    shapes = Shapes((spheres((0, 0, 0, 1), (0, 0, 0, 2)), planes((0, 1, 0, 1.5))))
    point = vec3(jnp.asarray([(0, 0, 0), (0, 1.2, 0), (0, 1.9, 0), (0, 3, 0), (5, 0, 0), (0, 0.5, 0)], float))
    but = jnp.asarray([-1, -1, -1, -1, -1, 0])
    rank = jnp.asarray([0, 1, 2])

    def around(spheres, planes):
        asked = tuple(jnp.asarray(numbers, jnp.int32) for numbers in (spheres, planes))
        return containing(shapes, point, asked, rank, but).tolist()

    assert around([0, 1], [2]) == [0, 1, 1, -1, 2, 1]
    assert around([1, 0, -1, -1], [2]) == [0, 1, 1, -1, 2, 1], "whatever their order, and with room to spare"
    assert around([], [2]) == [2, 2, -1, -1, 2, 2]
    assert around([], []) == [-1] * 6


# Derivatives


def distances(parameters):
    """Hit distances on a sphere (from outside and inside), a plane and a triangle, as a function of everything."""
    shapes = Shapes(
        (
            Spheres(vec3(parameters["centre"]), parameters["radius"]),
            Planes(vec3(parameters["normal"]), parameters["offset"]),
            Polygons(vec3(parameters["vertices"])),
        )
    )
    ray = Ray(vec3(parameters["origin"]), vec3(parameters["direction"]))
    hit = surface_at(shapes, ray, jnp.asarray([0, 0, 1, 2, NOTHING]), jnp.asarray([0, 1, 0, 0, 0]))
    return hit.distance, hit.point.stacked(), hit.normal.stacked()


PARAMETERS = {
    "centre": np.array([[0.1, 0.2, -3.0]]),
    "radius": np.array([0.8]),
    "normal": np.array([[0.0, 0.6, 0.8]]),
    "offset": np.array([-4.0]),
    "vertices": np.array([[(-1.0, -1.0, -2.0), (1.5, -1.0, -2.5), (0.0, 1.2, -2.2)]]),
    "origin": np.array([(0.2, 0.1, 0.3), (0.1, 0.3, -2.9), (0.0, 0.4, 0.0), (0.1, 0.1, 0.2), (9.0, 9.0, 9.0)]),
    "direction": np.array([(0.0, 0.0, -1.0), (0.6, 0.0, -0.8), (0.0, -0.6, -0.8), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)]),
}


@pytest.mark.parametrize("name", PARAMETERS)
def test_derivative_of_the_hit_against_central_differences(name):
    """The derivative is that of the formulas, with the direction as it is: no renormalisation is implied."""
    random = np.random.default_rng(4)
    tangent = {k: random.normal(size=v.shape) * (k == name) for k, v in PARAMETERS.items()}
    function = jax.jit(distances)
    forward = jax.jvp(function, (PARAMETERS,), (tangent,))[1]
    step = 1e-6
    plus, minus = (function({k: v + sign * step * tangent[k] for k, v in PARAMETERS.items()}) for sign in (1, -1))
    for ahead, p, m in zip(forward, plus, minus, strict=True):
        assert np.isfinite(ahead).all()
        np.testing.assert_allclose(ahead, (p - m) / (2 * step), rtol=1e-6, atol=1e-7)
    weights = tuple(random.normal(size=f.shape) for f in forward)
    gradient = jax.vjp(function, PARAMETERS)[1](weights)[0]
    inner = sum((gradient[k] * tangent[k]).sum() for k in gradient)
    np.testing.assert_allclose(inner, sum((w * f).sum() for w, f in zip(weights, forward, strict=True)), rtol=1e-10)


def test_a_miss_has_no_derivative():
    """Object -1: distance 0, normal zero, and derivatives of exactly zero in every shape."""
    shapes = Shapes((spheres((0, 0, 0, 1)), planes((0, 1, 0, 0)), polygons([(0, 0, 0), (1, 0, 0), (0, 1, 0)])))
    ray = rays((0, 5, 0), (1, 0, 0))

    def length_and_normal(shapes):
        hit = surface_at(shapes, ray, jnp.asarray([NOTHING]), jnp.asarray([0]))
        return hit.distance[0] + hit.normal.stacked().sum()

    assert length_and_normal(shapes) == 0
    assert all((g == 0).all() for g in jax.tree.leaves(jax.grad(length_and_normal)(shapes)))


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_derivatives_on_a_silhouette_and_along_a_plane_are_finite(mode):
    """Tangent to the sphere and parallel to the plane, where the derivative has no limit."""

    def distance(origin):
        shapes = Shapes((spheres((0, 0, 0, 1)), planes((0, 1, 0, 0))))
        ray = Ray(vec3(jnp.stack([origin, origin])), vec3(jnp.asarray([[1.0, 0.0, 0.0]] * 2)))
        return surface_at(shapes, ray, jnp.asarray([0, 1]), jnp.asarray([0, 0])).distance

    assert distance(jnp.asarray([-3.0, 1.0, 0.0])).tolist() == [3, 0]
    assert mode(distance)(jnp.asarray([-3.0, 1.0, 0.0])).tolist() == [[-1, 0, 0], [0, 0, 0]]


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize(
    "corners", [((-1, -1), (1, -1), (1, 1), (-1, 1)), ((-0.9, -1.03), (1.01, -0.87), (0.93, 1.07), (-1.1, 0.77))]
)
def test_two_triangles_leave_no_gap_along_the_side_they_share(precision, corners):
    """A pixel on the diagonal belongs to one of them, whichever way each runs along it."""
    a, b, c, d = ((*corner, 0.0) for corner in corners)
    camera = dw.Camera((0, 0, 5), (0, 0, 0), 20, 128, 128)
    paint = {"m": dw.Material(k_a=1.0)}

    def seen(*objects):
        return (
            np.asarray(dw.render(dw.Scene(objects=objects, materials=paint, precision=precision), camera)[..., 0]) > 0.5
        )

    whole = seen(dw.Polygon("whole", (a, b, c, d), "m"))
    halves = seen(dw.Polygon("one", (a, b, c), "m"), dw.Polygon("other", (a, c, d), "m"))
    assert whole.sum() > 5000
    assert not (whole & ~halves).any()


@pytest.mark.parametrize("silhouettes_first", [True, False])
def test_a_ray_that_has_run_past_all_it_can_name_is_cut_by_no_other(silhouettes_first):
    """Two spheres and then the horizon, whichever family is numbered first: the horizon counts whole."""
    balls, ground = spheres((100, 0, 0, 1), (200, 0, 0, 1)), planes((0, 1, 0, -1))
    shapes = Shapes((balls, ground) if silhouettes_first else (ground, balls))
    horizon, first, second = (2, 0, 1) if silhouettes_first else (0, 1, 2)
    ray = rays([(0, 0, 0)], [(0, 0, -1)])
    still = vec3(jnp.zeros((1, 3)))
    across, down = (Ray(still, vec3(jnp.asarray([step]))) for step in ((0.1, 0, 0), (0, 0.1, 0)))

    def met(*passed):
        nothing = jnp.full(1, NOTHING)
        sides = Departure(nothing, nothing >= 0, tuple(jnp.asarray([one]) for one in passed))
        primitive, _, _, cut = nearest_part(shapes, ray, Footprint(across, down, nothing), sides)
        return primitive.tolist(), cut.tolist()

    assert met(first, NOTHING) == ([horizon], [True])
    assert met(second, first) == ([NOTHING], [False])
