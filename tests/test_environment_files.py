"""Environments in scene files: there and back, with all that can be wrong, and in the files of other programs."""

import json
import shutil
from xml.etree import ElementTree

import numpy as np
import pytest
from environment_samples import ball_in, directions_of, picture, smooth

import diffwhitted as dw
from benchmarks import _povray
from diffwhitted import SceneError

SCENE = """
[scene]
background = {background}

[[camera]]
name = "main"
look_from = [0, 0, 4]
look_at = [0, 0, 0]
vfov_deg = 30
width = 8
height = 6
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with a map in another one below."""
    (tmp_path / "maps").mkdir()
    dw.write_image(tmp_path / "maps" / "room.exr", smooth(16))
    return tmp_path


def scene_of(folder, background):
    (folder / "scene.toml").write_text(SCENE.replace("{background}", background))
    return dw.load_scene(folder / "scene.toml")


def test_a_map_is_named_from_the_scene_file_and_back(folder):
    stated = '{ environment = "maps/room.exr", rotation_deg = 30, scale = 1.5, lights = false }'
    scene = scene_of(folder, stated)
    found = scene.background
    assert (float(found.rotation_deg), float(found.scale), found.lights) == (30, 1.5, False)
    np.testing.assert_array_equal(found.texels, smooth(16).astype(np.float32))
    (folder / "below").mkdir()
    dw.save_scene(scene, folder / "below" / "again.toml")
    text = (folder / "below" / "again.toml").read_text()
    assert 'environment = "../maps/room.exr"' in text and "lights = false" in text
    again = dw.load_scene(folder / "below" / "again.toml").background
    assert (float(again.rotation_deg), float(again.scale), again.lights) == (30, 1.5, False)
    np.testing.assert_array_equal(again.texels, found.texels)


def test_what_is_not_stated(folder):
    background = scene_of(folder, '{ environment = "maps/room.exr" }').background
    assert (float(background.rotation_deg), float(background.scale), background.lights) == (0, 1, True)
    names = [p.name for p in dw.parameters(scene_of(folder, '{ environment = "maps/room.exr" }'))]
    assert names[-2:] == ["background.rotation_deg", "background.scale"]


@pytest.mark.parametrize("count", [9, 16])
def test_harmonics_come_back_with_the_same_bits(count, folder):
    weights = np.random.default_rng(count).normal(size=(count, 3)).astype(np.float32)
    scene = ball_in(dw.HarmonicBackground(weights, lights=False), "float32", k_d=0.5)
    dw.save_scene(scene, folder / "scene.toml")
    again = dw.load_scene(folder / "scene.toml")
    assert not again.background.lights
    np.testing.assert_array_equal(again.background.harmonics, weights)
    assert float(dw.parameter_value(again, "background.harmonics.4.g")) == weights[4, 1]
    dw.save_scene(scene, folder / "scene.json")
    numbers = json.loads((folder / "scene.json").read_text())
    assert numbers["background"] == {"type": "harmonics", "lights": False}
    assert np.shape(numbers["parameters"]["background.harmonics"]["value"]) == (count, 3)


def test_the_schema_knows_both():
    tables = dw.scene_schema()["$defs"]
    assert tables["EnvironmentEntry"]["required"] == ["environment"]
    assert set(tables["EnvironmentEntry"]["properties"]) == {
        "environment",
        "encoding",
        "rotation_deg",
        "scale",
        "lights",
    }
    assert tables["HarmonicsEntry"]["required"] == ["harmonics"]


EVEN = ", ".join(["[1, 1, 1]"] * 10)
FAULTS = {
    '{ environment = "maps/rooms.exr" }': ["environment", "rooms.exr", "no such file"],
    '{ envronment = "maps/room.exr" }': ["background.envronment", 'Did you mean "environment"?'],
    '{ environment = "maps/room.exr", rotate_deg = 3 }': ["rotate_deg = 3", "rotation_deg"],
    '{ environment = "maps/room.exr", scale = -1 }': ["scale = -1", ">= 0"],
    '{ environment = "maps/room.exr", lights = 1 }': ["lights = 1", "true or false"],
    '{ environment = "maps/room.exr", gradient = [[0, 0, 0], [1, 1, 1]] }': ["unknown key background.gradient"],
    "{ environment = 3 }": ["environment = 3", "text in quotes"],
    f"{{ harmonics = [{EVEN}] }}": ["harmonics has 10 entries", "9 (up to degree 2) or 16"],
    "{ harmonics = [[1, 1, 1]] }": ["harmonics", "9 or more lists of 3 numbers"],
    '{ environment = "maps/wide.exr" }': ["wide.exr", "24 x 6 texels", "twice as wide as high", "12 x 6"],
    '{ environment = "maps/nan.exr" }': ["nan.exr", "row 2, column 3", "not finite or below 0"],
    '{ environment = "maps/below.exr" }': ["below.exr", "row 0, column 1", ">= 0 in every channel"],
    '{ environment = "scene.toml" }': ["environment", "scene.toml"],
}


@pytest.mark.parametrize("stated", FAULTS)
def test_what_is_wrong_is_said(stated, folder):
    bad, below = smooth(6), smooth(6)
    bad[2, 3, 1], below[0, 1] = np.nan, (-0.1, 1, 1)
    for name, texels in (("nan", bad), ("below", below), ("wide", np.ones((6, 24, 3)))):
        dw.write_image(folder / "maps" / f"{name}.exr", texels)
    with pytest.raises(SceneError) as error:
        scene_of(folder, stated)
    for words in FAULTS[stated]:
        assert words in str(error.value)


def test_what_is_wrong_in_python_is_said(folder):
    with pytest.raises(SceneError, match=r"texels has shape \(6, 12\)"):
        dw.EnvironmentBackground(np.ones((6, 12)))
    with pytest.raises(SceneError, match="harmonics has shape"):
        dw.HarmonicBackground(np.ones((9, 4)))
    with pytest.raises(SceneError, match="its texels are in no file"):
        dw.save_scene(ball_in(dw.EnvironmentBackground(smooth(6)), k_d=0.5), folder / "scene.toml")
    odd = dw.EnvironmentBackground(np.ones((1001, 2001, 3)))
    assert odd.texels.shape == (1001, 2001, 3)


# Other programs


def coloured(rotation_deg):
    """Red to the right, green above, blue ahead; seen from its middle."""
    x, y, z = np.moveaxis(directions_of(64, 128), -1, 0)
    texels = np.stack([np.clip(x, 0, 1) + 0.1, 0.5 + 0.5 * y, np.clip(-z, 0, 1) + 0.05], axis=-1)
    return dw.Scene(
        objects=[dw.Sphere("far", (0, -9, 90), 1, "paint")], materials={"paint": dw.Material(k_a=1, k_h=0)},
        background=dw.EnvironmentBackground(texels, rotation_deg=rotation_deg, scale=0.9),
        cameras={"main": dw.Camera((0, 0, 0), (0.1, 0.1, -1), 100, 24, 18)}, max_depth=1,
    )  # fmt: skip


@pytest.mark.skipif(shutil.which("povray") is None, reason=_povray.MISSING)
def test_povray_sees_the_same_map(tmp_path):
    scene = coloured(40)
    lost = dw.save_scene(scene, tmp_path / "scene.pov")
    assert any("scene_environment.exr" in sentence for sentence in lost)
    assert any("lights no surface" in sentence for sentence in lost)
    theirs = _povray.trace(tmp_path / "scene.pov", 24, 18, ("-A", f"+L{tmp_path}")).pixels
    np.testing.assert_allclose(picture(scene), theirs, atol=1e-3)


def test_mitsuba_gets_the_map_and_its_turn(tmp_path):
    """Its own picture was compared with ours: its left edge looks along -z, its azimuth runs towards +x, as ours."""
    lost = dw.save_scene(coloured(40), tmp_path / "scene.xml")
    root = ElementTree.parse(tmp_path / "scene.xml").getroot()
    emitter = next(one for one in root.iter("emitter") if one.get("type") == "envmap")
    assert emitter.find("string").get("value") == "scene_environment.exr"
    matrix = np.asarray(emitter.find("transform/matrix").get("value").split(), float).reshape(4, 4)
    # The middle of the map is at +z there, and is to be seen 40 degrees from -z towards +x.
    np.testing.assert_allclose(matrix[:3, :3] @ [0, 0, 1], [np.sin(np.radians(40)), 0, -np.cos(np.radians(40))])
    texels = dw.read_image(tmp_path / "scene_environment.exr").pixels
    np.testing.assert_allclose(texels, 0.9 * np.asarray(coloured(0).background.texels), rtol=1e-6)
    assert any("also in highlights" in sentence for sentence in lost)


def test_harmonics_leave_as_a_map_and_gltf_says_that_it_has_none(tmp_path):
    scene = ball_in(dw.HarmonicBackground(np.eye(9)[:, :3] * [1, 2, 0] + np.eye(9)[2][:, None] * [0, 0, 9]), k_d=0.5)
    lost = " ".join(dw.save_scene(scene, tmp_path / "scene.pov"))
    assert "harmonics of the background are a map" in lost and "below 0" in lost
    texels = dw.read_image(tmp_path / "scene_environment.exr").pixels
    assert texels.min() == 0 and texels[0, 0, 2] == pytest.approx(9 * np.sqrt(3 / (4 * np.pi)), rel=1e-3)
    assert "background are lost" in " ".join(dw.save_scene(scene, tmp_path / "scene.gltf"))
