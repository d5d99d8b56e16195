"""Glass that touches glass, water or what is opaque in a whole surface, against a tracer with one index a place."""

import dataclasses

import jax
import numpy as np
import pytest
from shared_surface_samples import box, picture, planes, scene, spheres, traced

import diffwhitted as dw
from diffwhitted.scene import shared_sheets
from diffwhitted.tree import make_plan

MATERIALS = {
    "glass": dw.Material(k_t=1, refractive_index=1.5),
    "water": dw.Material(k_t=1, refractive_index=1.33),
    "air": dw.Material(k_t=1, refractive_index=1.0),
}


def blocks(gap=0.0, half=1.0):
    """A block of glass before one of water."""
    return [*box("a", (-1, -1, 0), (1, 1, 0.4), "glass"), *box("b", (-half, -half, -0.4), (half, half, -gap), "water")]


def index_of_blocks(half):
    def index_at(point):
        x, y, z = point
        if max(abs(x), abs(y)) < 1 and 0 < z < 0.4:
            return 1.5
        return 1.33 if max(abs(x), abs(y)) < half and -0.4 < z < 0 else 1.0

    return index_at


def walls(half):
    sides = {-1.0, 1.0, -half, half}
    return planes(*((axis, side) for axis in (0, 1) for side in sides), (2, -0.4), (2, 0.0), (2, 0.4))


@pytest.mark.parametrize("half", [1.0, 0.6])
def test_blocks_that_share_a_face_bend_light_once(half):
    """From 1.5 to 1.33, whatever the order of the objects, also where one face is larger than the other."""
    right = traced(walls(half), index_of_blocks(half))
    for order in (1, -1):
        np.testing.assert_allclose(picture(scene(blocks(half=half)[::order], MATERIALS)), right, atol=1e-5)


def test_glass_glued_to_glass_reflects_nothing_at_the_joint():
    """At 45 degrees a gap would reflect all; two prisms of one glass that touch are one cube."""
    corners = {"low": (-1, -1), "right": (1, -1), "top": (1, 1), "left": (-1, 1)}

    def prism(name, *around):
        floor = [np.array([*corners[c], -1.0]) for c in around]
        roof = [point + (0, 0, 2.0) for point in floor]
        yield dw.Polygon(f"{name}_floor", floor[::-1], "glass")
        yield dw.Polygon(f"{name}_roof", roof, "glass")
        for k in range(3):
            m = (k + 1) % 3
            yield dw.Polygon(f"{name}_{k}", [floor[k], floor[m], roof[m], roof[k]], "glass")

    objects = [*prism("one", "low", "right", "top"), *prism("two", "low", "top", "left")]
    whole = list(box("cube", (-1, -1, -1), (1, 1, 1), "glass"))
    eye = (0.1, 5.0, 0.2)
    camera = dw.Camera(eye, (0, 0, 0), 12, 8, 6, up=(0, 0, 1))
    views = [dw.render(scene(some, MATERIALS), camera) for some in (objects, whole)]
    np.testing.assert_allclose(*views, atol=1e-5)


@pytest.mark.parametrize("names, index", [(("air", "water"), 1.33), (("water", "air"), 1.0)])
def test_a_hollow_that_is_filled_up_to_its_wall(names, index):
    """Of two spheres in one place the later one is the inner one."""
    balls = filled(*names)

    def index_at(point):
        away = np.linalg.norm(point)
        return index if away < 0.8 else 1.5 if away < 1 else 1.0

    right = traced(spheres(((0, 0, 0), 1), ((0, 0, 0), 0.8)), index_at)
    np.testing.assert_allclose(picture(scene(balls, MATERIALS)), right, atol=1e-5)


@pytest.mark.parametrize("order", [1, -1])
def test_a_block_that_stands_on_water(order):
    objects = [*box("b", (-0.7, 0, -0.7), (0.7, 0.8, 0.7), "glass"), dw.Plane("sea", (0, 1, 0), 0, "water")][::order]

    def index_at(point):
        x, y, z = point
        return 1.33 if y < 0 else 1.5 if max(abs(x), abs(z)) < 0.7 and y < 0.8 else 1.0

    right = traced(planes((0, -0.7), (0, 0.7), (2, -0.7), (2, 0.7), (1, 0), (1, 0.8)), index_at)
    np.testing.assert_allclose(picture(scene(objects, MATERIALS)), right, atol=1e-5)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("shadows", ["tinted", "opaque"])
@pytest.mark.parametrize("coaster", ["polygon", "plane"])
def test_a_glass_on_its_coaster(coaster, shadows, order):
    """Straight down through a block of index 1: k_t for the top and the bottom on the way there, and once more each
    on the way to the light where shadows are tinted; beside it the coaster is lit in full.
    """
    square = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]
    under = dw.Polygon("mat", square, "mat") if coaster == "polygon" else dw.Plane("mat", (0, 1, 0), 0, "mat")
    made = scene(
        [*box("b", (-0.5, 0, -0.5), (0.5, 0.4, 0.5), "clear"), under][::order],
        {"clear": dw.Material(k_t=0.8), "mat": dw.Material(k_a=0.1, k_d=0.5)},
        lights=[dw.DirectionalLight((0, 1, 0), 1)],
        shadows=shadows,
    )
    found = np.asarray(dw.render(made, dw.Camera((0, 5, 0), (0, 0, 0), 16, 8, 6, up=(0, 0, -1))))
    lit = 0.5 * 0.8**2 if shadows == "tinted" else 0.0
    np.testing.assert_allclose(found[2:4, 3:5], 0.8**2 * (0.1 + lit), rtol=1e-5)
    np.testing.assert_allclose(found[:, 0], 0.6, rtol=1e-5)


def filled(*names):
    return [dw.Sphere("ball", (0, 0, 0), 1, "glass"), *(dw.Sphere(n, (0, 0, 0), 0.8, n) for n in names)]


@pytest.mark.parametrize("footprint", [1, 2])
def test_filtered_trees_cross_both_spheres(footprint):
    """A hollow that is filled up to its wall is no hollow."""
    twice = picture(scene(filled("air", "water"), MATERIALS, footprint=footprint))
    np.testing.assert_allclose(twice, picture(scene(filled("water"), MATERIALS, footprint=footprint)), atol=1e-5)


def test_filtered_trees_cross_both_faces():
    """As 8 x 8 points do; at the edges a tree's mean is a linear one (points one a pixel are off by 0.017)."""
    touching = picture(scene(blocks(), MATERIALS, footprint=1))
    points = picture(scene(blocks(), MATERIALS), samples=8)
    assert np.median(abs(touching - points)) < 1e-3
    assert np.sqrt(np.mean((touching - points) ** 2)) < 0.016


def test_derivatives_are_finite_and_those_of_the_picture():
    """In the index beyond the shared surface, against central differences in float64."""
    made = scene(filled("air", "water"), MATERIALS, precision="float64")
    plan = dw.plan(made, made.cameras["main"])

    @jax.jit
    def image(value):
        changed = dw.replace_coefficient(made, "water.refractive_index", value)
        return dw.render(changed, made.cameras["main"], plan=plan)

    slope = np.asarray(jax.jit(jax.jacfwd(image))(1.33))
    difference = np.asarray(image(1.33 + 1e-6) - image(1.33 - 1e-6)) / 2e-6
    assert np.isfinite(slope).all() and abs(slope).max() > 0.5
    np.testing.assert_allclose(slope, difference, atol=1e-5)


# What is called for


def test_only_surfaces_that_overlap_are_looked_at():
    glass = {"one", "two"}
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)

    def sheets(shift, turned=False):
        other = square + shift
        two = dw.Polygon("two", other[::-1] if turned else other, "m")
        return shared_sheets([dw.Polygon("one", square, "m"), two], glass)

    assert sheets((0.5, 0, 0)) == ((("one", True), ("two", True)),)
    assert sheets((0.5, 0, 0), turned=True) == ((("one", True), ("two", False)),)
    assert sheets((1, 0, 0)) == sheets((0.5, 0, 1e-4)) == sheets((5, 0, 0)) == ()
    assert shared_sheets([dw.Polygon("a", square, "m"), dw.Polygon("b", square, "m")], glass) == ()
    tilted = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]])
    moved = [dw.Polygon(n, np.float32((square + s) @ tilted + 5), "m") for n, s in (("one", 0), ("two", (0.2, 0.1, 0)))]
    assert len(shared_sheets(moved, glass)) == 1
    wall = dw.Plane("wall", (0, 0, -2), 0, "m")
    assert shared_sheets([dw.Polygon("one", square, "m"), wall], glass) == ((("one", True), ("wall", False)),)


def test_a_plan_for_apart_is_refused_for_touching():
    apart, touching = scene(blocks(gap=1e-3), MATERIALS), scene(blocks(), MATERIALS)
    camera = apart.cameras["main"]
    assert "shared_surfaces" not in make_plan(apart, camera).effects
    with pytest.raises(dw.SceneError, match="it leaves out shared_surfaces, which the scene calls for"):
        dw.render(touching, camera, plan=make_plan(apart, camera))
    plan = make_plan(touching, camera)
    forgetful = dataclasses.replace(plan, shared=())
    with pytest.raises(dw.SceneError, match="objects 'a_20' and 'b_21' did not share a surface when it was made"):
        dw.render(touching, camera, plan=forgetful)
