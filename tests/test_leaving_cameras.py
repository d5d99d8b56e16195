"""Cameras as other programs have them: values by hand, and POV-Ray's own picture of what is written for it."""

import json
import math
import shutil
from xml.etree import ElementTree

import numpy as np
import pytest
import unknown_kinds
from leaving_samples import everything

import diffwhitted as dw
from benchmarks import _povray

SIDES = dict(width=40, height=30)
FROM, AT = [0, 0, 5], [0, 0, 0]
"""Right is x and up is y."""


@pytest.fixture
def written(tmp_path):
    """A scene with these cameras as text in a format, and what was lost of them."""

    def write(suffix, shots=(), **cameras):
        scene = dw.Scene(
            objects=[dw.Sphere("ball", [0, 0, 0], 1, "m")], materials={"m": dw.Material()}, cameras=cameras, shots=shots
        )
        lost = dw.save_scene(scene, tmp_path / f"scene.{suffix}")
        about = [sentence for sentence in lost if "camera" in sentence or "shot" in sentence]
        return (tmp_path / f"scene.{suffix}").read_text(encoding="utf-8"), about

    return write


def numbers(element):
    return {part.get("name"): float(part.get("value")) for part in element.findall("float")}


def test_focal_lengths_in_the_middle_are_an_angle(written):
    """tan(vfov / 2) = 15 / 50."""
    view = dw.Camera(FROM, AT, focal=[50, 50], principal_point=[20, 15], **SIDES)
    text, lost = written("pov", main=view)
    assert "direction <0,0,1.66666666667> up <0,1,0> right <1.33333333333,0,0> sky <0,1,0> look_at <0,0,0>" in text
    xml, lost_of_xml = written("xml", main=view)
    sensor = next(ElementTree.fromstring(xml).iter("sensor"))
    assert numbers(sensor) == {"fov": pytest.approx(math.degrees(2 * math.atan(0.3)))}
    gltf, lost_of_gltf = written("gltf", main=view)
    (camera,) = json.loads(gltf)["cameras"]
    assert camera["perspective"]["yfov"] == pytest.approx(2 * math.atan(0.3))
    assert camera["perspective"]["aspectRatio"] == pytest.approx(4 / 3)
    assert lost == lost_of_xml == lost_of_gltf == []


def test_a_skewed_view_in_povray_by_hand(written):
    """Pixel 40 x 30 of 50 and 60 pixels: at 1 m ahead the picture is 0.8 x 0.5 m, its middle (20 - 12) / 50 to the
    right of look_at and (20 - 15) / 60 above it. z is turned round.
    """
    view = dw.Camera(FROM, AT, focal=[50, 60], principal_point=[12, 20], distortion=[0, 0, 0, 0], **SIDES)
    text, lost = written("pov", main=view)
    skew = "location <0,0,-5> direction <0.16,0.0833333333333,1> up <0,0.5,0> right <0.8,0,0> }"
    assert skew in text and lost == []
    # The window's middle is at column 3 + 8, row 5 + 4.5.
    crop = dw.Camera(FROM, AT, focal=[50, 60], principal_point=[12, 20], crop=[3, 5, 16, 9], **SIDES)
    text, lost = written("pov", main=crop)
    assert "direction <-0.02,0.175,1> up <0,0.15,0> right <0.32,0,0> }" in text and "+W16 +H9" in text and lost == []


def test_skews_of_mitsuba_by_hand(written):
    """Offsets are parts of the picture, as in Mitsuba 3.9.1, whose rays are those of the camera to 4e-7."""
    crop = dw.Camera(FROM, AT, focal=[50, 60], principal_point=[12, 20], crop=[3, 5, 16, 9], **SIDES)
    xml, lost = written("xml", main=crop)
    (sensor,) = ElementTree.fromstring(xml).iter("sensor")
    assert numbers(sensor) == {
        "fov": pytest.approx(math.degrees(2 * math.atan(4.5 / 60))),
        "principal_point_offset_x": pytest.approx(-1 / 16),
        "principal_point_offset_y": pytest.approx(-10.5 / 9),
    }
    assert {part.get("name"): part.get("value") for part in sensor.find("film").findall("integer")} == {
        "width": "16", "height": "9",
    }  # fmt: skip
    assert lost == ['Mitsuba: focal of camera "main": that down the picture is also that across, as pixels are square']


def test_what_gltf_has_no_word_for_is_told(written):
    middle = dw.Camera(FROM, AT, 40, crop=[10, 5, 20, 20], **SIDES)
    corner = dw.Camera(FROM, AT, 40, crop=[0, 0, 20, 20], **SIDES)
    aside = dw.Camera(FROM, AT, focal=[50, 60], principal_point=[12, 20], crop=[3, 5, 16, 9], **SIDES)
    text, lost = written("gltf", middle=middle, corner=corner, aside=aside)
    lenses = [camera["perspective"] for camera in json.loads(text)["cameras"]]
    half = math.tan(math.radians(20))
    assert [lens["yfov"] for lens in lenses] == pytest.approx(
        [2 * math.atan(half * 20 / 30), math.radians(40), 2 * math.atan(15 / 60)]
    )
    # 40 / 50 wide and 30 / 60 high.
    assert [lens["aspectRatio"] for lens in lenses] == pytest.approx([1, 4 / 3, 0.8 / 0.5])
    assert lost == [
        'glTF: crop of cameras "corner", "aside" is lost: the full picture is seen',
        'glTF: principal_point of camera "aside" is lost: look_at is in the middle of the picture',
    ]


def test_parallel_rays_by_hand(written):
    """0.1 m a pixel; the window's middle is 0.1 m to the left of look_at and 1.05 m above it."""
    view = dw.OrthographicCamera(FROM, AT, 3, principal_point=[12, 20], crop=[3, 5, 16, 9], **SIDES)
    text, lost = written("pov", main=view)
    assert (
        "camera { orthographic location <-0.1,1.05,-5> up <0,0.9,0> right <1.6,0,0> sky <0,1,0> look_at <-0.1,1.05,0> }"
    ) in text
    xml, lost_of_xml = written("xml", main=view)
    (sensor,) = ElementTree.fromstring(xml).iter("sensor")
    scale, look = sensor.find("transform")
    assert sensor.get("type") == "orthographic" and scale.attrib == {"x": "0.8", "y": "0.8"}
    assert look.attrib == {"origin": "-0.1, 1.05, 5", "target": "-0.1, 1.05, 0", "up": "0, 1, 0"}
    gltf, lost_of_gltf = written("gltf", main=view)
    file = json.loads(gltf)
    lens = file["cameras"][0]["orthographic"]
    assert file["cameras"][0]["type"] == "orthographic"
    assert [lens[key] for key in ("xmag", "ymag", "znear")] == pytest.approx([0.8, 0.45, 0])
    # The ball's far side is 6 m away.
    assert lens["zfar"] > 6
    node = next(node for node in file["nodes"] if "camera" in node)
    assert node["matrix"] == pytest.approx([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -0.1, 1.05, 5, 1])
    assert lost == lost_of_xml == lost_of_gltf == []


@pytest.mark.parametrize("suffix", ["pov", "xml", "gltf"])
def test_a_distortion_is_told(suffix, written):
    text, lost = written(suffix, lens=dw.Camera(FROM, AT, 40, distortion=[0.1, 0, 0, 0], **SIDES))
    assert len(lost) == 1 and lost[0].endswith(': distortion of camera "lens" is lost')
    assert lost[0].partition(": ")[2] in text.replace(r"\"", '"')


@pytest.mark.parametrize("suffix", ["pov", "xml", "gltf"])
def test_a_camera_of_an_unknown_kind_is_left_out(suffix, written):
    """The others are there, the first of them first."""
    with unknown_kinds.known():
        around = unknown_kinds.Panorama(FROM, AT, 2, **SIDES)
        text, lost = written(suffix, around=around, other=dw.Camera(FROM, AT, 40, **SIDES))
        alone, lost_alone = written(suffix, around=around)
    assert lost == lost_alone and len(lost) == 1 and lost[0].endswith('left out: camera "around" (panorama)')
    found = {"pov": "camera {", "xml": "<sensor", "gltf": '"perspective": {'}[suffix]
    assert text.count(found) == 1 and found not in alone


@pytest.mark.parametrize("suffix", ["pov", "xml", "gltf", "mtl", "tex", "md"])
def test_shots_are_told_once(suffix, written):
    views = {name: dw.Camera(FROM, AT, 40, **SIDES) for name in ("a", "b")}
    shots = [dw.Shot(name, camera=name, exposure=2.0) for name in views]
    said = [sentence for sentence in written(suffix, shots=shots, **views)[1] if "shot" in sentence]
    assert len(said) == 1 and said[0].endswith(": left out: what the scene says of its pictures (2 in [[shot]])")
    assert not any("shot" in sentence for sentence in written(suffix, **views)[1])


def test_json_says_what_cameras_and_shots_are(written):
    views = {
        "a": dw.Camera(FROM, AT, focal=[50, 60], crop=[3, 5, 16, 9], **SIDES),
        "b": dw.OrthographicCamera(FROM, AT, 3, **SIDES),
    }
    shots = [dw.Shot("one", camera="a", picture="one.exr", exposure=2.0, noise=(0.01, 0.02), lights=[])]
    text, lost = written("json", shots=shots, **views)
    content = json.loads(text)
    assert lost == []
    assert content["cameras"] == {
        "a": {"type": "perspective", "width": 40, "height": 30, "crop": [3, 5, 16, 9]},
        "b": {"type": "orthographic", "width": 40, "height": 30},
    }
    assert content["shots"] == {
        "one": {"camera": "a", "picture": "one.exr", "lights": [], "noise": [0.01, 0.02]},
    }  # fmt: skip
    assert content["parameters"]["camera.a.focal"]["value"] == [50, 60]
    assert content["parameters"]["shot.one.exposure"]["value"] == 2


WINDOW = dict(width=240, height=200, principal_point=[95, 120], crop=[30, 50, 160, 120], up=[0.1, 1, 0.2])
VIEWS = {
    "skewed": dw.Camera([0.3, 0.8, 6], [0, 0.1, 0], focal=[190, 160], **WINDOW),
    "parallel": dw.OrthographicCamera([0.3, 0.8, 6], [0, 0.1, 0], 7, **WINDOW),
}


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("povray") is None, reason=_povray.MISSING)
@pytest.mark.parametrize("kind", VIEWS)
def test_povray_sees_the_same(kind, tmp_path):
    """Through a window aside, pixels that are not square, and parallel rays; as the second of two cameras."""
    plain = everything()
    scene = dw.Scene(
        objects=plain.objects, materials=plain.materials, textures=plain.textures, lights=plain.lights,
        background=plain.background, ambient=plain.ambient, max_depth=plain.max_depth,
        cameras={**plain.cameras, kind: VIEWS[kind]},
    )  # fmt: skip
    (told,) = dw.save_scene(scene, tmp_path / "scene.pov")
    assert "one camera at a time" in told
    theirs = _povray.trace(tmp_path / "scene.pov", 160, 120, ("-A", "Declare=View=2")).pixels
    apart = np.abs(np.asarray(dw.render(scene, VIEWS[kind])) - theirs).max(axis=-1)
    assert np.median(apart) < 2e-4 and np.quantile(apart, 0.99) < 5e-4
    assert (apart > 0.01).mean() < 2e-3
