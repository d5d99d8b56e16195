"""Lamps with a size: one ray and outlines by hand, points that are added up, POV-Ray, derivatives, a fit."""

import json
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from test_lights import against_differences

import diffwhitted as dw
import fitting
from diffwhitted.accuracy._reference import rmse
from diffwhitted.accuracy._tracer import Tracer
from diffwhitted.formats import scene_text
from diffwhitted.geometry import Footprint, Ray
from diffwhitted.illumination import light_footprint, seen_of_ball
from diffwhitted.numerics._vector import Vec3
from diffwhitted.records import in_dtype
from diffwhitted.scene import tabulate
from diffwhitted.scene.lights._spread import over_ball, over_square

CENTRE, RADIUS = (0.1, 3.0, -0.2), 0.3
BALLS = {"one": ((-0.3, 1.0, 0.1), 0.25), "two": ((0.25, 1.3, -0.1), 0.2), "low": ((-0.05, 0.5, 0.22), 0.06)}
ABOVE = dict(ambient=0, max_depth=1, precision="float64")


def scene(lamp=None, objects=None, **settings) -> dw.Scene:
    """A floor that fills the picture, balls above the camera, and a lamp above them."""
    balls = [dw.Sphere(name, *where, "paint") for name, where in BALLS.items()]
    return dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0), 0, "paint"), *(balls if objects is None else objects)],
        materials={"paint": dw.Material(k_d=0.8, k_h=0)},
        lights=[dw.SphereLight(CENTRE, RADIUS, 1.0, name="lamp") if lamp is None else lamp],
        cameras={"main": dw.Camera((0, 0.4, 0.01), (0, 0, 0), 100, 16, 12)},
        **(ABOVE | settings),
    )


def floor(there):
    """The points of the floor, (n, 3)."""
    camera = there.cameras["main"]
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    rays = camera.rays(columns.ravel(), rows.ravel())
    origin, ways = (np.asarray(v.stacked(), np.float64) for v in (rays.origin, rays.direction))
    return origin - ways * (origin[:, 1:2] / ways[:, 1:2])


def seen(points, balls):
    """s of Parker et al. 3.2 for a ball of light past balls, and N.L."""
    to_light = np.asarray(CENTRE) - points
    distance = np.linalg.norm(to_light, axis=1)
    unit = to_light / distance[:, None]
    least = np.ones(len(points))
    for centre, radius in balls:
        to_ball = np.asarray(centre) - points
        t = (to_ball * unit).sum(axis=1)
        m = np.linalg.norm(to_ball - t[:, None] * unit, axis=1) - radius
        w = RADIUS * t / distance
        tau = np.clip((m + w) / (2 * w), 0, 1)
        least = np.minimum(least, 3 * tau**2 - 2 * tau**3)
    return least, unit[:, 1]


def test_one_ray_past_balls_is_what_the_formula_says():
    there = scene()
    least, cosine = seen(floor(there), BALLS.values())
    assert ((least > 0.05) & (least < 0.95)).sum() > 20 and (least == 0).any() and (least == 1).any()
    found = np.asarray(dw.render(there, there.cameras["main"]))[..., 0]
    np.testing.assert_allclose(found.ravel(), 0.8 * cosine * least, atol=1e-12)


def test_one_ray_past_a_straight_edge_is_what_many_points_say():
    """Of the points of a ball the share 3 t^2 - 2 t^3 lies on one side of a plane, so the two are the same there."""
    board = [dw.Polygon("board", [(-9, 1.5, -9), (0.1, 1.5, -9), (0.3, 1.5, 9), (-9, 1.5, 9)], "paint")]
    pictures = [
        np.asarray(dw.render(there, there.cameras["main"]))
        for there in (scene(dw.SphereLight(CENTRE, RADIUS, 1.0, samples=n), board) for n in (0, 512))
    ]
    part = pictures[0][..., 0]
    assert ((part > 0.1) & (part < 0.6)).sum() > 20
    np.testing.assert_allclose(*pictures, atol=0.012)


def test_derivatives_in_the_numbers_of_lamp_and_occluder():
    names = ["light.lamp.radius", "light.lamp.centre.x", "light.lamp.centre.y", "light.lamp.colour.g",
             "object.one.centre.x", "object.two.radius", "object.low.centre.y"]  # fmt: skip
    forward, central = against_differences(scene(), names, step=1e-6)
    np.testing.assert_allclose(forward, central, rtol=1e-4, atol=1e-4)
    assert (np.abs(forward) > 0.01).all()


def test_a_footprint_widens_the_penumbra():
    """A small lamp's shadow against many points in each pixel, and its derivative in ball and lamp by differences."""
    shapes = tabulate(scene(objects=[dw.Sphere("ball", (0, 1, 0), 0.3, "paint")])).shapes
    x = jnp.linspace(-0.6, 0.6, 25)
    side = 0.04

    def share(values, x=x, side=side):
        radius, of_ball = values
        there = eqx.tree_at(lambda s: s.families[0].radius, shapes, of_ball[None])
        place = Vec3(x, jnp.zeros_like(x), jnp.zeros_like(x))
        lamp = in_dtype(dw.SphereLight((0.0, 3.0, 0.0), radius, 1), np.dtype(float))
        to_light, distance, _ = lamp.arriving(place)
        ball = jnp.zeros(x.shape, jnp.int32)
        step = Vec3(jnp.full_like(x, side), jnp.zeros_like(x), jnp.zeros_like(x))
        still = Ray(Vec3(0 * x, 0 * x, 0 * x), Vec3(0 * x, 0 * x, 0 * x))
        footprint = Footprint(Ray(step, still.direction), still)
        pixel = light_footprint(lamp, place, footprint) if side else None
        return seen_of_ball(there, Ray(place, to_light), radius / distance, pixel, ball)

    values = jnp.asarray(0.01), jnp.asarray(0.3)
    inner = (jnp.arange(64) + 0.5) / 64 * side - side / 2
    many = share(values, (x[:, None] + inner).ravel(), 0.0).reshape(len(x), -1).mean(axis=1)
    found = share(values)
    assert ((found > 0.1) & (found < 0.9)).any() and np.abs(found - many).max() < 0.06
    for way in ((1.0, 0.0), (0.0, 1.0)):
        way = tuple(map(jnp.asarray, way))
        slope = jax.jvp(share, (values,), (way,))[1]
        ends = [share(jax.tree.map(lambda v, w, s=sign: v + s * 1e-6 * w, values, way)) for sign in (1, -1)]
        np.testing.assert_allclose(slope, (ends[0] - ends[1]) / 2e-6, atol=1e-5)
        assert np.abs(slope).max() > 0.1


def test_derivatives_reach_a_lamp_through_its_points():
    """Without shadows, so that each point's light is smooth."""
    lamp = dw.SphereLight(CENTRE, RADIUS, 1.0, samples=3, attenuation=(0, 0, 1), clamped=False, name="lamp")
    flat = dw.RectangleLight((0, 3, 0), (1, 0, 0.2), (0, 0.3, 1), 0.5, samples=2, attenuation=(0, 1, 1), name="flat")
    there = scene(lamp, shadows="off")
    there = dw.Scene(
        objects=there.objects, materials=there.materials, lights=[lamp, flat], cameras=there.cameras, shadows="off",
        **ABOVE,
    )  # fmt: skip
    names = [
        "light.lamp.radius", "light.lamp.centre.y", "light.lamp.colour.g", "light.flat.corner.x", "light.flat.edge_u.z",
        "light.flat.edge_v.y", "light.flat.colour.r", "light.flat.attenuation.a2",
    ]  # fmt: skip
    forward, central = against_differences(there, names, step=1e-5)
    np.testing.assert_allclose(forward, central, rtol=1e-5)


@pytest.mark.parametrize("count", [1, 2, 7, 16, 64])
def test_points_are_spread_evenly(count):
    square, ball = over_square(count), over_ball(count)
    assert square.shape == (count, 2) and ball.shape == (count, 3)
    assert ((square > 0) & (square < 1)).all() and (np.linalg.norm(ball, axis=1) < 1.2).all()
    np.testing.assert_allclose(ball.mean(axis=0), 0, atol=1e-12)
    for column in square.T:
        assert np.abs(np.sort(column) - (np.arange(count) + 0.5) / count).max() <= 0.5 / count
    if count == 64:
        for axis in np.random.default_rng(0).normal(size=(20, 3)):
            t = 0.5 + 0.5 * np.linspace(-0.9, 0.9, 19)
            share = ((ball @ axis / np.linalg.norm(axis))[None] < 2 * t[:, None] - 1).mean(axis=1)
            assert np.abs(share - (3 - 2 * t) * t**2).max() < 0.08


def test_a_rectangle_converges_to_what_povray_sees():
    """POV-Ray's grid of 17 x 17 points, 16 x 12 pixels of half floats, against 256 points of ours."""
    book = json.loads((Path(__file__).parent / "oracles" / "povray_lights.json").read_text())["rectangle"]
    there = dw.parse_scene(book["scene"], precision="float64")
    ours, theirs = np.asarray(dw.render(there, there.cameras["main"])), np.asarray(book["picture"])
    assert ((theirs > 0.1) & (theirs < 0.3)).sum() > 30
    assert np.abs(ours - theirs).max() < 0.02 and np.sqrt(np.mean((ours - theirs) ** 2)) < 0.004


def test_they_are_saved_and_bounded_and_noted():
    lamps = [
        dw.SphereLight(CENTRE, RADIUS, (1, 0.5, 0), samples=4, attenuation=(0.5, 0, 1), clamped=False, name="ball"),
        dw.RectangleLight((0, 3, 0), (1, 0, 0), (0, 0, 1), 0.5, name="flat"),
    ]
    there = dw.Scene(objects=[], materials={}, lights=lamps)
    assert eqx.tree_equal(dw.parse_scene(scene_text(there)), there)
    assert [light.brightest().tolist() for light in lamps] == [[2, 1, 0], [0.5] * 3]
    with pytest.raises(dw.SceneError, match="samples = 0; allowed is a whole number from 1 to 1024"):
        dw.RectangleLight((0, 3, 0), (1, 0, 0), (0, 0, 1), 0.5, samples=0)
    with pytest.raises(dw.SceneError, match="lie along one line"):
        dw.RectangleLight((0, 3, 0), (1, 0, 0), (2, 0, 0), 0.5)
    with pytest.warns(dw._errors.SceneNote, match="the outline of objects of type box is not known"):
        scene(objects=[dw.Box("box", (0, 1, 0), (0.2, 1.2, 0.2), "paint")])


def test_one_knob_chooses_between_one_ray_and_points():
    """What the scene says is left alone; points come nearer and nearer to many of them."""
    there = scene(precision="float32", objects=[dw.Sphere("one", *BALLS["one"], "paint")])
    tracer = Tracer(there, there.cameras["main"])
    pictures = {n: tracer.trace(dw.Settings(light_samples=n)).pixels for n in (None, 0, 4, 64, 256)}
    np.testing.assert_array_equal(pictures[None], pictures[0])
    off = {n: rmse(pictures[n], pictures[256]) for n in (0, 4, 64)}
    assert off[64] < 0.5 * off[4] and off[0] < 0.5 * off[4]
    assert str(dw.Settings(light_samples=4)) == "depth 5, light samples 4, 1 point"
    with pytest.raises(dw.SceneError, match="light_samples = -1; allowed is a whole number from 0 to 1024"):
        dw.Settings(light_samples=-1)


def test_a_fit_finds_the_size_of_a_lamp():
    there = scene(precision="float32", max_depth=2)
    target = np.asarray(dw.render(there, there.cameras["main"], footprint=2))
    result = fitting.fit(there, target, ["light.lamp.radius"], start={"light.lamp.radius": 0.12})
    assert result["light.lamp.radius"].value == pytest.approx(RADIUS, abs=0.01)
