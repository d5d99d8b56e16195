"""Outlines of meshes under a footprint: which sides may be one, which one a ray has, and what moves with them."""

import functools
import warnings
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.accuracy._reference import rmse
from diffwhitted.geometry import BITS, Asked, Ray, _compiled, boxes_over, free
from diffwhitted.geometry._sides import Passed, nearest_side
from diffwhitted.numerics._vector import Vec3, vec3
from diffwhitted.shapes._mesh_sides import shared_sides
from references.supersampled import area_true, cosine, relative

WAY, STEP = np.asarray([1.0, 0.3, 0.2], np.float32), 5e-3


def ball(rings=6, around=10):
    """Vertices and faces of a closed ball of triangles."""
    up, turn = np.linspace(0, np.pi, rings + 1)[1:-1], np.arange(around) * 2 * np.pi / around
    ring = [np.stack([np.sin(u) * np.cos(turn), np.full(around, np.cos(u)), np.sin(u) * np.sin(turn)], 1) for u in up]
    vertices = np.concatenate([[[0, 1, 0]], *ring, [[0, -1, 0]]]).astype(np.float32)
    last, faces = len(vertices) - 1, []
    for k in range(around):
        after = (k + 1) % around
        faces += [[0, 1 + after, 1 + k], [last, last - around + k, last - around + after]]
        for r in range(rings - 2):
            a, b = 1 + r * around + k, 1 + r * around + after
            faces += [[a, b, b + around], [a, b + around, a + around]]
    return vertices, np.asarray(faces)


def scene(far=0.0):
    """A smooth ball of glass-free paint and a block with flat faces, over a floor that catches their shadows; both are
    moved."""
    vertices, faces = ball()
    corners = np.asarray([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)], np.float32)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    move = WAY * far
    smooth = dw.Mesh("ball", vertices, faces, "paint", normals=vertices).placed(
        translate=move + np.float32([-0.8, 0, 0])
    )
    block = dw.Mesh("block", corners, quads, "paint").placed(
        translate=move + np.float32([1.0, -0.2, 0.3]), rotate_deg=np.float32([20, 30, 10])
    )
    return dw.Scene(
        objects=[smooth, block, dw.Plane("ground", [0, 1, 0], -1.3, "floor")],
        materials={"paint": dw.Material(k_d=[0.8, 0.3, 0.2], k_a=0.1), "floor": dw.Material(k_d=0.7, k_a=0.2)},
        background=dw.ConstantBackground([0.4, 0.6, 0.9]),
        lights=[dw.PointLight([3, 5, 4], [1.0] * 3)],
        cameras={"main": dw.Camera([0, 0.8, 5], [0.1, -0.2, 0], 40, 64, 48)},
    )


def test_every_side_is_there_once_with_what_lies_beyond():
    """A tetrahedron has six sides of two faces each; a sheet of two triangles one, and four of its border."""
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    solid = dw.Mesh("solid", corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], "m")
    side, other = shared_sides([solid])
    assert len(side) == 6 and (other >= 0).all()
    faces = np.asarray(solid.faces)
    for one, beyond in zip(side, other, strict=True):
        place, triangle = one >> BITS, one & ((1 << BITS) - 1)
        ends = {int(faces[triangle, place]), int(faces[triangle, (place + 1) % 3])}
        third = int(faces[beyond & ((1 << BITS) - 1), beyond >> BITS])
        assert third not in ends and ends < set(faces[beyond & ((1 << BITS) - 1)].tolist())
    sheet = dw.Mesh("sheet", [*corners[:3], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]], "m")
    assert (shared_sides([sheet])[1] < 0).sum() == 4
    # Vertices that a file repeats are one.
    twice = dw.Mesh("twice", [*corners[:3], corners[1], [1, 1, 0], corners[2]], [[0, 1, 2], [3, 4, 5]], "m")
    assert (shared_sides([sheet, twice])[1] < 0).sum() == 8
    # A side of three faces is one of each alone.
    fan = dw.Mesh("fan", [*corners, [0, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]], "m")
    assert (shared_sides([fan])[1] < 0).all()


@pytest.mark.parametrize("creases", [False, True])
def test_every_search_finds_the_same_side(monkeypatch, creases):
    """One after the other, through the tree, and by machine code; and what is found is an outline by float64."""
    vertices, faces = ball(9, 14)
    mesh = dw.Mesh("ball", vertices, faces, "m")
    sides = mesh.alone().sides(*map(jnp.asarray, shared_sides([mesh])))
    low, high = sides.box()
    tree = jax.tree.map(
        jnp.asarray, boxes_over(*(np.asarray(c.stacked()) for c in (low, high)), np.asarray(sides.numbers()))
    )
    tree = replace(tree, cones=sides.cones(tree.leaf))
    random = np.random.default_rng(3)
    origin = random.normal(size=(2000, 3))
    origin = 3 * origin / np.linalg.norm(origin, axis=1, keepdims=True)
    to = random.normal(size=(2000, 3))
    to = to / np.linalg.norm(to, axis=1, keepdims=True) * random.uniform(0.5, 1.1, (2000, 1)) - origin
    to = to / np.linalg.norm(to, axis=1, keepdims=True)
    ray = Ray(*(vec3(jnp.asarray(v, jnp.float32)) for v in (origin, to)))
    reach, zero = jnp.full(2000, 0.01, jnp.float32), jnp.zeros(2000, jnp.float32)
    nothing = Vec3(*(zero * jnp.nan,) * 3)
    asked = Asked(ray, free((2000,)), zero + 10, None, reach, reach, Passed((nothing, nothing)))
    machine = nearest_side(sides, tree, asked, creases)
    monkeypatch.setattr(_compiled, "_machine", lambda: None)
    walked, brute = nearest_side(sides, tree, asked, creases), nearest_side(sides, None, asked, creases)
    assert 50 < (np.asarray(brute[0]) >= 0).sum() < 1950
    for found in (machine, walked):
        # Which of two sides that meet at a corner is left open.
        assert ((np.asarray(found[0]) >= 0) == (np.asarray(brute[0]) >= 0)).all()
        np.testing.assert_allclose(found[1], brute[1], rtol=1e-4)
    # Look whether both triangles lie on one side of the plane through the eye.
    number = np.asarray(brute[0])
    found = jax.tree.map(lambda a: np.asarray(a, np.float64)[number[number >= 0]], sides)
    start, end, one, other = (
        v.stacked() - origin[number >= 0] for v in (found.start, found.end, found.corner, found.beyond)
    )
    plane = np.cross(start, end)
    outline = (plane * one).sum(axis=1) * (plane * other).sum(axis=1) > 0
    assert outline.mean() > 0.99 or creases


@functools.cache
def truth():
    camera = scene().cameras["main"]
    below, above = (area_true(scene(far), camera, 24) for far in (-STEP, STEP))
    return (below + above) / 2, (above - below) / (2 * STEP)


@functools.cache
def ours():
    """Picture and derivative of one filtered tree a pixel, as the meshes move."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = dw.derivative(scene, 0.0, scene().cameras["main"], footprint=1, refine=False)
    return found.image.astype(np.float64), found.slope.astype(np.float64)


@pytest.mark.slow
def test_a_filtered_mesh_is_like_many_points():
    point = np.asarray(dw.render(scene(), scene().cameras["main"], footprint=0))
    assert rmse(ours()[0], truth()[0]) < 0.15 * rmse(point, truth()[0])


@pytest.mark.slow
def test_the_derivative_sees_outlines_creases_and_shadows_move():
    along, true = ours()[1], truth()[1]
    assert np.isfinite(along).all()
    assert cosine(along, true) > 0.97 and relative(along, true) < 0.25
