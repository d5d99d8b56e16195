"""Lamps that do not shine alike to all sides, ambient light of a sky and a ground, and light that fades on its way."""

import json
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED
from lights_scene import by_hand, scene

import diffwhitted as dw
import fitting
from diffwhitted.formats import scene_text
from diffwhitted.geometry import Footprint, Ray
from diffwhitted.illumination import SurfacePoint, within_borders
from diffwhitted.numerics._vector import Vec3
from diffwhitted.records import changed, in_dtype
from diffwhitted.tree import make_plan

SMOOTH = [
    "light.spot.position.x", "light.spot.look_at.z", "light.spot.colour.r", "light.spot.exponent",
    "light.spot.inner_cone_deg", "light.spot.cone_deg", "light.spot.attenuation.a1", "light.hard.position.y",
    "light.barn.direction.z", "light.barn.exponent", "scene.ambient.sky.g", "scene.ambient.ground.b",
    "scene.ambient.up.x", "scene.distance_fade.a", "scene.distance_fade.b",
]  # fmt: skip
EDGES = ["light.hard.direction.x", "light.hard.cone_deg", "light.barn.flaps_x.lo", "light.barn.flaps_z.hi"]
"""What moves hard edges of light and nothing else."""


def test_each_point_gets_what_the_formulas_say():
    there = scene()
    np.testing.assert_allclose(dw.render(there, there.cameras["main"]), by_hand(there), atol=1e-12)


def test_a_footprint_averages_over_edges_of_light():
    """Against many points by hand. What is left is the curvature of edges whose cone is two pixels wide."""
    there = scene(footprint=1)
    found, expected = np.asarray(dw.render(there, there.cameras["main"])), by_hand(there, 24)
    points = by_hand(there)
    assert np.abs(found - expected).max() < 0.011 < 0.1 < np.abs(points - expected).max()
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.15 * np.sqrt(np.mean((points - expected) ** 2))


def against_differences(there, names, step=1e-4):
    """The derivative of a weighted sum over the picture in each number, in both modes, and by central differences."""
    camera = there.cameras["main"]
    plan = make_plan(there, camera, capacity=4 * camera.width * camera.height)
    values = np.asarray([float(dw.parameter_value(there, name)) for name in names])
    weights = np.random.default_rng(3).uniform(0.2, 1, (camera.height, camera.width, 3))

    def total(values):
        new = there
        for name, value in zip(names, values, strict=True):
            new = dw.replace_parameter(new, name, value)
        return (dw.render(new, camera, plan=plan) * weights).sum()

    along = jax.jit(lambda values, way: jax.jvp(total, (values,), (way,)), compiler_options=SOON_COMPILED)
    ways = np.eye(len(names))
    forward = np.asarray([along(values, way)[1] for way in ways])
    backward = jax.jit(jax.grad(total), compiler_options=SOON_COMPILED)(values)
    np.testing.assert_allclose(forward, backward, rtol=1e-9, atol=1e-12)
    ends = [[float(along(values + sign * step * way, way)[0]) for sign in (1, -1)] for way in ways]
    central = np.subtract(*np.transpose(ends)) / (2 * step)
    return forward, central


def test_derivatives_at_points_are_those_of_the_smooth_part():
    """No edge of light moves over a point within the step; what moves hard edges alone has derivative 0."""
    forward, central = against_differences(scene(), SMOOTH + EDGES, step=1e-6)
    smooth = len(SMOOTH)
    np.testing.assert_allclose(forward[:smooth], central[:smooth], rtol=1e-5)
    assert (np.abs(forward[:smooth]) > 1e-2).all() and (forward[smooth:] == 0).all()


def square(side):
    """Places on the floor z = 0 of the lamps below, each the middle of a square pixel."""
    across = np.linspace(-0.3, 0.3, 5)
    x, z = (jnp.asarray(v.ravel()) for v in np.meshgrid(across, across))
    zero, one = jnp.zeros_like(x), jnp.ones_like(x)
    up, none = Vec3(zero, one, zero), Vec3(zero, zero, zero)
    sides = Ray(Vec3(side * one, zero, zero), none), Ray(Vec3(zero, zero, side * one), none)
    return SurfacePoint(
        there=one > 0, position=Vec3(x, zero, z), normal=up, shading_normal=up, incoming=-up, distance=one,
        entering=one > 0, material=jnp.zeros(x.shape, int), models={}, coefficients={}, index_here=None,
        index_beyond=None, footprint=Footprint(*sides), curvature=zero,
    )  # fmt: skip


BORDERED = {
    "hard cone": dw.SpotLight((0.05, 1.0, 0.1), 1, direction=(0.1, -1, 0), cone_deg=15),
    "soft cone": dw.SpotLight((0.05, 1.0, 0.1), 1, look_at=(0.0, 0, 0), cone_deg=18, inner_cone_deg=14),
    "cone of no width": dw.SpotLight((0.05, 1.0, 0.1), 1, look_at=(0.0, 0, 0), cone_deg=15, inner_cone_deg=15),
    "flaps": dw.WarnLight((0, 1, 0), (0, -1, 0), 1, flaps_x=(-0.22, 0.11), flaps_z=(-0.07, -0.03)),
}


@pytest.mark.parametrize("kind", BORDERED)
def test_an_edge_of_light_in_a_pixel(kind):
    """The share of the pixel against points in it, and its derivative in each number against differences."""
    lamp = in_dtype(BORDERED[kind], np.dtype(float))
    side = 0.1
    point, numbers = square(side), [row.name for row in lamp.ROWS if row.numeric and row.moves != "nothing"]
    names = [name for name in numbers if getattr(lamp, name) is not None]

    def share(values):
        return within_borders(changed(lamp, **values), point)

    values = {name: jnp.asarray(getattr(lamp, name)) for name in names}
    found = share(values)
    inner = (np.arange(40) + 0.5) / 40 * side - 0.5 * side
    x, z = (np.asarray(getattr(point.position, axis))[:, None] + inner[None] for axis in "xz")
    x, z = jnp.asarray(x[:, :, None] + 0 * z[:, None]), jnp.asarray(0 * x[:, :, None] + z[:, None])
    alone = changed(point, position=Vec3(x, 0 * x, z), footprint=None)
    expected = np.asarray(within_borders(lamp, alone)).mean(axis=(1, 2))
    assert ((found > 0.05) & (found < 0.95)).any() and np.abs(found - expected).max() < 0.06
    for name in names:
        way = np.random.default_rng(5).normal(size=values[name].shape)
        slope = jax.jvp(lambda v, n=name: share(values | {n: v}), (values[name],), (jnp.asarray(way),))[1]
        ends = [share(values | {name: values[name] + sign * 1e-6 * way}) for sign in (1, -1)]
        np.testing.assert_allclose(slope, (ends[0] - ends[1]) / 2e-6, atol=1e-6)
        assert (np.abs(slope).max() > 1e-3) == ((kind, name) != ("flaps", "direction"))
        assert np.isfinite(jax.grad(lambda v, n=name: share(values | {n: v}).sum())(values[name])).all()


LAMPS = """
[scene]
ambient = { sky = [0.3, 0.4, 0.6], ground = [0.2, 0.1, 0.05] }
distance_fade = [0.9, -0.05]
[[light]]
type = "spot"
name = "spot"
position = [-1, 2, 0.5]
look_at = [-0.8, -1, 0]
colour = [0.9, 0.7, 0.5]
exponent = 3
inner_cone_deg = 12
cone_deg = 24
attenuation = [0.2, 0.1, 0.05]
clamped = false
[[light]]
type = "warn"
name = "barn"
position = [1, 3, 0]
direction = [0, -1, 0.5]
colour = [1, 1, 0.5]
flaps = { x = [-1, 0.5], z = [0, 2] }
"""


def test_lamps_of_a_file_are_read_named_and_written():
    there = dw.parse_scene(LAMPS)
    spot, barn = there.lights
    assert (spot.look_at.tolist(), float(spot.exponent), spot.clamped) == ([pytest.approx(-0.8), -1, 0], 3, False)
    assert (barn.flaps_x.tolist(), barn.flaps_y, barn.flaps_z.tolist()) == ([-1, 0.5], None, [0, 2])
    assert eqx.tree_equal(dw.parse_scene(scene_text(there)), there)
    names = [parameter.name for parameter in dw.parameters(there)]
    assert [name for name in names if name.startswith(("light.barn", "scene"))] == [
        "light.barn.position", "light.barn.direction", "light.barn.colour", "light.barn.flaps_x", "light.barn.flaps_z",
        "scene.ambient.sky", "scene.ambient.ground", "scene.ambient.up", "scene.distance_fade",
    ]  # fmt: skip
    moved = dw.replace_parameter(there, "scene.ambient.sky.g", 0.7)
    assert float(dw.parameter_value(moved, "scene.ambient.sky.g")) == pytest.approx(0.7)
    assert float(dw.parameter_value(there, "light.barn.flaps_x.hi")) == 0.5
    assert dw.parse_scene(LAMPS.replace("clamped = false", "")).lights[0].held


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("look_at =", "direction = [0, 1, 0]\nlook_at =", "look_at and direction; allowed is one of the two"),
        ("look_at = [-0.8, -1, 0]", "", "neither look_at nor direction"),
        ("look_at = [-0.8, -1, 0]", "look_at = [-1, 2, 0.5]", "any point but its position"),
        ("inner_cone_deg = 12", "inner_cone_deg = 30", "inner_cone_deg = 30; allowed is up to cone_deg = 24"),
        ("cone_deg = 24", "", "inner_cone_deg without a cone_deg"),
        ("attenuation = [0.2, 0.1, 0.05]", "", "clamped without an attenuation"),
        ("x = [-1, 0.5]", "x = [1, 0.5]", "flaps: x = [1, 0.5]; allowed is [lo, hi] with lo < hi"),
        ("x = [-1, 0.5]", "w = [1, 0.5]", "unknown key flaps.w = [1, 0.5]"),
        ("sky = [0.3, 0.4, 0.6]", "sky = [0.3, -0.4, 0.6]", "sky = [0.3, -0.4, 0.6]; allowed is >= 0"),
        ("sky = [0.3, 0.4, 0.6], ", "", "ambient.sky is missing"),
        ("[0.9, -0.05]", "[0.9, -0.05, 1]", "distance_fade = [0.9, -0.05, 1]; allowed is a list of 2 numbers"),
        ("[0.9, -0.05]", "[0, -0.05]", "so no light would arrive"),
    ],
)
def test_what_is_wrong_with_a_lamp_is_said(old, new, said):
    assert old in LAMPS
    with pytest.raises(dw.SceneError) as error:
        dw.parse_scene(LAMPS.replace(old, new, 1))
    assert said in str(error.value)


def test_the_two_words_for_a_fade_that_is_not_held_must_not_contradict():
    def lamp(**keys):
        return dw.PointLight((0, 0, 1), 1, attenuation=(0, 0, 1), **keys)

    assert not lamp(clamped=False).held and not lamp(attenuation_limit="none", clamped=False).held
    assert lamp(clamped=True).held and lamp(attenuation_limit="one", clamped=True).held
    with pytest.raises(dw.SceneError, match='attenuation_limit = "none" contradicts clamped = true'):
        lamp(attenuation_limit="none", clamped=True)


def test_povray_sees_the_same():
    """The picture that POV-Ray 3.7 rendered of what is written for it; half floats are good to 2.4e-4 of a value."""
    book = json.loads((Path(__file__).parent / "oracles" / "povray_lights.json").read_text())
    there = dw.parse_scene(book["spots"]["scene"], precision="float64")
    theirs = np.asarray(book["spots"]["picture"])
    ours = np.asarray(dw.render(there, there.cameras["main"]))
    assert ours.max() > 0.3
    np.testing.assert_allclose(ours, theirs, atol=2e-4)


def test_a_fit_finds_numbers_of_lamps():
    """A cone, flaps, a place, and the ambient light: from edges of light that moved by a pixel and more."""
    there = scene(precision="float32", max_depth=2)
    target = np.asarray(dw.render(there, there.cameras["main"], samples=8))
    start = {
        "light.spot.cone_deg": 22.0, "light.barn.flaps_x.lo": -0.5, "light.hard.position.x": 0.35,
        "scene.ambient.sky.g": 0.2, "scene.distance_fade.b": -0.03,
    }  # fmt: skip
    result = fitting.fit(there, target, list(start), start=start)
    for name in start:
        near = 0.3 if name.endswith("deg") else 0.01
        assert result[name].value == pytest.approx(float(dw.parameter_value(there, name)), abs=near), name


def test_the_bound_knows_of_fades_and_lamps():
    """No tree is brighter than the bound, and a fade that grows has none."""
    mirror = dict(materials={"paint": dw.Material(k_a=0.5, k_d=0.3, k_s=0.6, k_h=0)}, max_depth=1)
    there = scene(distance_fade=(0.9, -0.02))
    there = changed(there, materials=mirror["materials"], max_depth=2)
    camera = there.cameras["main"]
    bounded = dw.render_with_bound(there, camera, max_depth=1)
    deep = np.asarray(dw.render(there, camera))
    assert np.isfinite(bounded.left_out).all() and (deep <= bounded.image + bounded.left_out + 1e-9).all()
    growing = changed(there, distance_fade=np.asarray([0.5, 0.1]))
    assert np.isinf(dw.render_with_bound(growing, camera, max_depth=1).left_out).any()


def test_light_fades_along_each_ray_of_a_path():
    """A mirror before a wall that glows: both lengths count, each by itself."""
    there = dw.Scene(
        objects=[dw.Plane("mirror", (0, 0, 1), -2, "mirror"), dw.Plane("wall", (0, 0, -1), -6, "wall")],
        materials={"mirror": dw.Material(k_s=0.5, k_h=0), "wall": dw.Material(k_a=1.0, k_h=0)},
        cameras={"main": dw.Camera((0, 0, 3), (0, 0, 0), 40, 16, 12)},
        distance_fade=(0.8, -0.04),
        precision="float64",
    )
    expected = 0.5 * (0.8 - 0.04 * 5 * slant(there)) * (0.8 - 0.04 * 8 * slant(there))
    np.testing.assert_allclose(dw.render(there, there.cameras["main"])[..., 0], expected, rtol=1e-6)


def test_a_ray_that_runs_past_a_silhouette_has_come_all_the_way():
    """A black board before a wall that glows: what passes it has the fade of the whole way from the wall."""
    there = dw.Scene(
        objects=[
            dw.Plane("wall", (0, 0, 1), -2, "wall"),
            dw.Polygon("board", [(-9, -9, -1), (0.21, -9, -1), (0.37, 9, -1), (-9, 9, -1)], "black"),
        ],
        materials={"wall": dw.Material(k_a=1.0, k_h=0), "black": dw.Material(k_h=0)},
        cameras={"main": dw.Camera((0, 0, 3), (0, 0, 0), 40, 16, 12)},
        distance_fade=(0.8, -0.1),
        max_depth=1,
        precision="float64",
    )
    camera = there.cameras["main"]
    averaged = np.asarray(dw.render(there, camera, footprint=1))[..., 0]
    many = np.asarray(dw.render(there, camera, samples=16))[..., 0]
    fades = 0.8 - 0.1 * 5 * slant(there)
    part = averaged / fades
    assert ((part > 0.1) & (part < 0.9)).sum() >= 6
    np.testing.assert_allclose(averaged, many, atol=0.01)  # of 16 points across an edge


def slant(there):
    """1 over the cosine of each ray of the camera with its axis."""
    camera = there.cameras["main"]
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    ways = camera.rays(columns.ravel(), rows.ravel()).direction
    return -1 / np.asarray(ways.z).reshape(camera.height, camera.width)
