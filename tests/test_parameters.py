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

SIDE, SAMPLES = 3, 12
STEP = {"m": 0.04, "deg": 0.4}
"""Half the distance of the two pictures of a difference; 0.5 % of the value, at least 1e-3, of what has another
unit.
"""


NAMES = [parameter.name for parameter in dw.parameters(one_of_each())]
BRANCHES = tuple(name for name in NAMES if name.endswith((".k_s", ".k_t")))
TOLERANCE = {"rays": 0.06, "shadows": 0.06, "patterns": 0.05}
"""Relative distance of a derivative from the difference of pictures of 12 x 12 points a pixel, whose own grain is some
3 %.
"""


def found(name: str) -> dw.Parameter:
    return next(parameter for parameter in dw.parameters(one_of_each()) if parameter.name == name)


@functools.cache
def programs(moving: bool):
    """The picture with its derivative along a tangent, and the picture of many points; compiled once for all names.

    Where something moves each pixel is a filtered tree, of camera rays alone (what moves through mirrors and glass,
    `test_edges` tells); where nothing does it is one point, with mirrors and glass.
    """
    scene, depth = one_of_each(), 1 if moving else 2
    camera, free = scene.cameras["main"], () if moving else BRANCHES
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
    for registry, things in ((OBJECTS, scene.objects), (LIGHTS, scene.lights), (TEXTURES, scene.textures.values())):
        assert {type(thing) for thing in things} == set(registry)
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


@pytest.mark.parametrize("name", NAMES)
def test_the_derivative_in_every_number(name):
    scene, parameter = one_of_each(), found(name)
    moving = parameter.row.moves != "nothing"
    slope, points = programs(moving)
    why = idle(scene, parameter, (*BRANCHES, name), max_depth=1 if moving else 2, cameras=("main",))
    for unknown in list_unknowns(scene, [name]):
        (value,) = values_in(scene, [unknown], scene)
        here, tangent = moved(unknown, value)
        image, along = slope(here, tangent)
        if why is not None:
            assert not np.any(along), (unknown.name, why)
            continue
        assert np.isfinite(along).all()
        step = STEP.get(unknown.unit, max(1e-3, 0.005 * abs(value)))
        if parameter.row.moves == "nothing":
            step = 1e-6
        ends = [moved(unknown, value + way)[0] for way in (step, -step)]
        if parameter.row.moves == "nothing":
            zero = jax.tree.map(jnp.zeros_like, ends[0])
            high, low = (np.asarray(slope(end, zero)[0]) for end in ends)
            central = (high - low) / (2 * step)
            np.testing.assert_allclose(along, central, atol=2e-6 * max(abs(central).max(), 1e-3), err_msg=unknown.name)
        else:
            central = (squares(points(ends[0])) - squares(points(ends[1]))) / (2 * step)
            away = np.linalg.norm(squares(along) - central) / np.linalg.norm(central)
            print(f"AWAY {unknown.name} {away:.4f} {np.linalg.norm(central):.3g}")
            assert away < TOLERANCE[parameter.row.moves], unknown.name
        assert np.abs(central).max() > 0, unknown.name
