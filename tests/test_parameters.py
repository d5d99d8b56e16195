"""A name for every number: reading, replacing, derivatives against differences, and what is said of a wrong name.

The table test runs over all parameters of a scene that has one of each kind. Where nothing moves, the derivative is
that of the same picture by central differences; where edges move, the difference is that of pictures of many points a
pixel, averaged over squares of pixels, which knows nothing of footprints.
"""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.scene import BACKGROUNDS, LIGHTS, OBJECTS, TEXTURES
from diffwhitted.tree import idle
from fitting.problem._unknowns import insert, list_unknowns, values_in
from references.one_of_each import one_of_each

SIDE, SAMPLES = 3, 32
STEP = {"m": 0.08, "deg": 0.8}
"""Half the distance of two pictures of many points, about a third of a pixel: large against the grain of the points."""
SMOOTH, JUMPS = 2e-5, 1e-3
"""Relative distance from the difference of the same picture; where edges move, a footprint's own decisions have
kinks.
"""
ALIKE = 0.9
"""Least cosine with the difference of pictures of many points, over all numbers of a parameter. One tree stands for a
pixel of 2.5 degrees here, in which a footprint is a coarse thing (measured: 0.953 and more)."""

NAMES = [parameter.name for parameter in dw.parameters(one_of_each())]
SWITCHES = tuple(name for name in NAMES if name.endswith((".k_s", ".k_t", ".extinction")))
"""Numbers that start an effect when they leave zero."""


def found(name: str) -> dw.Parameter:
    return next(parameter for parameter in dw.parameters(one_of_each()) if parameter.name == name)


@functools.cache
def programs(moving: bool):
    """The picture with its derivative along a tangent, and the picture of many points; compiled once for all names.

    Where something moves each pixel is a filtered tree, of camera rays alone (what moves through mirrors and glass,
    `test_edges` tells); where nothing does it is one point, with mirrors and glass.
    """
    scene, depth = one_of_each(), 1 if moving else 2
    camera, free = scene.cameras["main"], () if moving else SWITCHES
    plans = [dw.plan(scene, camera, footprint=trees, free=free, max_depth=depth) for trees in (int(moving), 0)]
    plans = [plan.with_capacity(2 * plan.capacity) for plan in plans]

    def picture(scene):
        return dw.render(scene, scene.cameras["main"], plan=plans[0])

    slope = eqx.filter_jit(lambda scene, tangent: jax.jvp(picture, (scene,), (tangent,)))
    points = eqx.filter_jit(lambda scene: dw.render(scene, scene.cameras["main"], plan=plans[1], samples=SAMPLES))
    return slope, points


def squares(picture) -> np.ndarray:
    """Averaged over squares of pixels."""
    height, width, _ = picture.shape
    return np.asarray(picture).reshape(height // SIDE, SIDE, width // SIDE, SIDE, 3).mean(axis=(1, 3))


def leaves(scene) -> dict:
    """The arrays of a scene by where they are; a k_h that is not stated has none."""
    return {jax.tree_util.keystr(path): leaf for path, leaf in jax.tree_util.tree_leaves_with_path(scene)}


def moved(unknown, value):
    """The scene with another value of one unknown, and how it changes with it."""
    return jax.jvp(lambda v: insert(one_of_each(), (unknown,), v), (jnp.full(1, value),), (jnp.ones(1),))


def test_the_scene_has_one_of_each_kind():
    scene = one_of_each()
    # Of patterns that are heights too, `test_wrinkles` asks the same.
    assert {type(thing) for thing in scene.textures.values()} == {dw.Checker, dw.ImageTexture} < set(TEXTURES)
    # Of the lamps with a cone or a size, `test_lights` and `test_soft_shadows` ask the same.
    assert {type(light) for light in scene.lights} == {dw.PointLight, dw.DirectionalLight} < set(LIGHTS)
    # Of the other shapes, which know points only but for the disc, `test_shape_records` asks the same.
    assert {type(thing) for thing in scene.objects} == {dw.Sphere, dw.Polygon, dw.Plane} < set(OBJECTS)
    assert type(scene.background) in set(BACKGROUNDS)


@pytest.mark.parametrize("name", NAMES)
def test_a_number_is_read_replaced_and_put_back(name):
    scene, parameter = one_of_each(), found(name)
    value = np.asarray(dw.parameter_value(scene, name))
    # A value next to it, by which every scene stays valid.
    other = value * 1.01 + (0 if parameter.row.scale == "log" or name.endswith("vertices") else 0.001)
    changed = dw.replace_parameter(scene, name, other)
    np.testing.assert_allclose(dw.parameter_value(changed, name), other, rtol=1e-12)
    before, after = leaves(scene), leaves(changed)
    other_leaves = {key for key, leaf in after.items() if not np.array_equal(leaf, before.get(key, np.nan))}
    assert len(other_leaves) == 1, other_leaves
    back = leaves(dw.replace_parameter(changed, name, value))
    for key, leaf in before.items():
        np.testing.assert_array_equal(back[key], leaf)
    if name == "object.board.vertices":
        return  # One number of one corner alone would bend it: see below.
    for component in parameter.components(scene):
        index = parameter.index(scene, component)
        one = dw.replace_parameter(scene, f"{name}.{component}", other[index])
        expected = value.copy()
        expected[index] = other[index]
        np.testing.assert_allclose(dw.parameter_value(one, name), expected, rtol=1e-12)
        assert dw.parameter_value(scene, f"{name}.{component}") == value[index]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_derivative_in_every_number(name):
    scene, parameter = one_of_each(), found(name)
    moving = parameter.row.moves != "nothing"
    slope, points = programs(moving)
    why = idle(scene, parameter, (*SWITCHES, name), max_depth=1 if moving else 2, cameras=("main",))
    along_all, truth_all = [], []
    for unknown in list_unknowns(scene, [name]):
        (value,) = values_in(scene, [unknown], scene)
        here, tangent = moved(unknown, value)
        along = np.asarray(slope(here, tangent)[1])
        if why is not None:
            assert not np.any(along), (unknown.name, why)
            continue
        central = difference(lambda scene: slope(scene, jax.tree.map(jnp.zeros_like, scene))[0], unknown, value, 1e-6)
        away = np.linalg.norm(along - central)
        assert away <= (JUMPS if moving else SMOOTH) * max(np.linalg.norm(central), 1e-3), (unknown.name, away)
        if moving:
            along_all.append(squares(along))
            truth_all.append(squares(difference(points, unknown, value, STEP[unknown.unit])))
    if along_all:
        along, truth = np.stack(along_all), np.stack(truth_all)
        cosine = (along * truth).sum() / np.linalg.norm(along) / np.linalg.norm(truth)
        assert cosine > ALIKE, (name, cosine)


def difference(picture, unknown, value, step) -> np.ndarray:
    """The central difference; to one side of what is at the end of its interval."""
    low = 0.0 if value == unknown.row.lowest else -step
    ends = [np.asarray(picture(moved(unknown, value + way)[0])) for way in (step, low)]
    return (ends[0] - ends[1]) / (step - low)
