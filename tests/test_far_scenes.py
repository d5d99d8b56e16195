"""A scene far from the origin of its coordinates is the picture, the derivative and the fit that it is here."""

import jax
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted._errors import FarFromOrigin
from fitting import fit

FAR = np.array([400000.0, 30.5, 500000.0])
PLACE = {k: np.array(v) for k, v in {
    "eye": (0, 1.2, 5), "aim": (0, 0, 0), "lamp": (3, 5, 4), "ball": (-0.8, 0, 0), "lens": (0.8, 0, 0.3),
    "a": (-3, -0.7, -2), "b": (1, -0.7, -3), "c": (-1, 2, -2.5),
}.items()}  # fmt: skip
NORMAL = np.array([0.1, 1.0, -0.05])


def text(by=FAR, footprint=0):
    """Two balls, a slanted checked floor and a sheet, as a file has them after a move."""

    def at(name):
        return [float(f"{x:.10g}") for x in PLACE[name] + by]

    return f"""
[scene]
background = {{ gradient = [[0.1, 0.2, 0.3], [0.5, 0.6, 0.7]] }}
shadows = "tinted"
footprint = {footprint}
[[camera]]
look_from = {at("eye")}
look_at = {at("aim")}
vfov_deg = 40
width = 40
height = 30
[[light]]
type = "point"
position = {at("lamp")}
colour = [1, 1, 1]
[[texture]]
name = "t"
type = "checker"
colours = [[0.9, 0.2, 0.2], [1, 1, 1]]
size = 0.7
axes = "xz"
[[material]]
name = "floor"
k_a = 0.1
k_d = 0.8
k_d_texture = "t"
k_a_texture = "t"
[[material]]
name = "paint"
k_a = 0.1
k_d = [0.6, 0.2, 0.1]
k_h = 0.3
phong_exponent = 40
[[material]]
name = "glass"
k_t = 0.9
k_s = 0.1
k_h = 0.5
refractive_index = 1.5
[[object]]
name = "ball"
type = "sphere"
centre = {at("ball")}
radius = 0.7
material = "paint"
[[object]]
name = "lens"
type = "sphere"
centre = {at("lens")}
radius = 0.7
material = "glass"
[[object]]
name = "ground"
type = "plane"
normal = {NORMAL.tolist()}
offset = {float(-0.7 + NORMAL @ by)!r}
material = "floor"
[[object]]
name = "sheet"
type = "triangle"
vertices = [{at("a")}, {at("b")}, {at("c")}]
material = "paint"
"""


def here_and_there(by=FAR, **settings):
    """The same scene twice. The floor's pattern is that of the world, so a place to compare with is a whole period
    away.
    """
    return dw.parse_scene(text(np.zeros(3), **settings)), dw.parse_scene(text(by, **settings))


WHOLE = 1.4 * np.array([300000.0, 25.0, 400000.0])


@pytest.mark.parametrize("footprint", [0, 1])
def test_far_away_looks_like_here(footprint):
    """Numbers of float32's precision at 4e5 m would move things by centimetres; these are the digits of the file."""
    here, there = here_and_there(WHOLE, footprint=footprint)
    one, other = (np.asarray(dw.render(s, s.cameras["main"])) for s in (here, there))
    # The decimal digits of the file are good to 1e-5 m at this place; an edge of the pattern may fall otherwise.
    off = np.abs(one - other).max(axis=-1)
    assert one.std() > 0.1 and np.mean(off > 0.01) <= 0.003 and off.mean() < 1e-3


def test_the_derivative_far_away_is_that_here():
    here, there = here_and_there(WHOLE)

    def slope(scene):
        return dw.derivative(
            lambda k: dw.replace_coefficient(scene, "paint.k_d", k), (0.6, 0.2, 0.1), scene.cameras["main"], footprint=0
        ).slope

    off = np.abs(slope(here) - slope(there)).max(axis=-1)
    assert np.mean(off > 0.01) <= 0.003


def test_files_and_numbers_stay_in_the_coordinates_of_the_user(tmp_path):
    scene = dw.parse_scene(text())
    np.testing.assert_array_equal(scene.objects[0].centre, PLACE["ball"] + FAR)
    assert scene.precision == "float32" and scene.keeps_digits
    dw.save_scene(scene, tmp_path / "saved.toml")
    again = dw.load_scene(tmp_path / "saved.toml")
    assert jax.tree.structure(again) == jax.tree.structure(scene)
    for one, other in zip(jax.tree.leaves(again), jax.tree.leaves(scene), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_camera_of_its_own_and_arrays_of_float64():
    """The camera need not be one of the scene; and records built from NumPy are as those of a file."""
    scene = dw.parse_scene(text(WHOLE))
    camera = dw.Camera(PLACE["eye"] + WHOLE, PLACE["aim"] + WHOLE, 40, 40, 30)
    np.testing.assert_array_equal(dw.render(scene, camera), dw.render(scene, scene.cameras["main"]))


def test_what_was_float32_is_told_so():
    eye, aim = (np.float32(PLACE[name] + FAR) for name in ("eye", "aim"))
    with pytest.warns(FarFromOrigin, match="float32 resolves 0.031 m"):
        dw.Scene(objects=[], materials={}, cameras={"main": dw.Camera(eye, aim, 40, 4, 3)})


def test_a_fit_far_away():
    """k_d of the ball from a picture taken here, from elsewhere; the fitted scene is still where it was."""
    here, there = here_and_there(WHOLE)
    target = np.asarray(dw.render(here, here.cameras["main"]))
    result = fit(dw.replace_coefficient(there, "paint.k_d", (0.3, 0.3, 0.3)), target, ["paint.k_d"])
    np.testing.assert_allclose([c.value for c in result.coefficients], [0.6, 0.2, 0.1], atol=2e-3)
    np.testing.assert_array_equal(result.scene.objects[0].centre, there.objects[0].centre)


@pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
def test_cameras_far_from_each_other():
    """Each sees what is near it."""
    scene = dw.parse_scene(text(WHOLE))
    both = dw.Scene(
        objects=scene.objects,
        materials=scene.materials,
        lights=scene.lights,
        textures=scene.textures,
        background=scene.background,
        shadows="tinted",
        cameras={
            "main": scene.cameras["main"],
            "other": dw.Camera((0, 5e6, 0), (0, 5e6 + 1, 0), 1, 4, 3, up=(1, 0, 0)),
        },
    )
    np.testing.assert_array_equal(dw.render(both, both.cameras["main"]), dw.render(scene, scene.cameras["main"]))
    # Straight up there is only the sky.
    np.testing.assert_allclose(
        dw.render(both, both.cameras["other"]), np.broadcast_to((0.5, 0.6, 0.7), (3, 4, 3)), atol=1e-3
    )
