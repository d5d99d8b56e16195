"""Depth, normal and object of what a pixel sees first: against the geometry of a ball over a floor; and in a file."""

import json

import numpy as np
import OpenImageIO as oiio
import pytest

import diffwhitted as dw
from diffwhitted.image import ImageError, read_image
from fitting.command_line import main


def scene():
    """A ball at the origin, a floor 1 m below its middle, and nothing above the horizon."""
    return dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0), -1, "grey"), dw.Sphere("ball", (0, 0, 0), 1, "grey")],
        materials={"grey": dw.Material(k_d=0.5)},
        lights=[dw.PointLight((2, 3, 4), 1.0)],
        cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 60, 21, 15)},
    )


def test_layers_are_those_of_a_ball_over_a_floor():
    seen = dw.layers(scene(), scene().cameras["main"])
    ball, floor, nothing = seen.of("ball"), seen.of("floor"), seen.object == -1
    assert np.all(ball ^ floor ^ nothing) and seen.names[seen.object[7, 10]] == "ball"
    # The middle: the nearest point of the ball. Its outline: sin of the angle is 1/4.
    assert seen.depth[7, 10] == pytest.approx(3, abs=1e-5)
    np.testing.assert_allclose(seen.normal[7, 10], (0, 0, 1), atol=1e-5)
    half = np.tan(np.radians(30))
    across, down = np.meshgrid((np.arange(21) - 10) / 7.5 * half, (np.arange(15) - 7) / 7.5 * half)
    tangent = np.hypot(across, down)
    np.testing.assert_array_equal(ball, tangent < 1 / np.sqrt(15))
    # Rays of the middle row are level: rounding decides.
    floor[7], nothing[7] = False, False
    np.testing.assert_array_equal(floor, ~ball & (down > 0))
    # Along the ray the floor is 1 m below at 1 / sin of the angle of depression.
    length = np.sqrt(1 + tangent**2)
    np.testing.assert_allclose(seen.depth[floor], (length / np.where(down > 0, down, 1))[floor], rtol=1e-5)
    np.testing.assert_allclose(seen.normal[floor], np.broadcast_to((0, 1, 0), (floor.sum(), 3)), atol=1e-6)
    assert np.all(np.isinf(seen.depth[nothing])) and np.all(seen.normal[nothing] == 0)


def test_layers_lie_beside_the_picture(tmp_path, capsys):
    dw.save_scene(scene(), tmp_path / "scene.toml")
    assert main(["render", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "a.exr"), "--layers"]) == 0
    expected = dw.layers(scene(), scene().cameras["main"])
    read = read_image(tmp_path / "a.exr")
    np.testing.assert_array_equal(read.pixels, np.asarray(dw.render(scene(), scene().cameras["main"])))
    numbers = read_image(tmp_path / "a.exr", layer="object.id").pixels[..., 0]
    np.testing.assert_array_equal(numbers, expected.object)
    file = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    spec = file.spec()
    assert spec.channelnames[3:] == ("depth.Z", "normal.X", "normal.Y", "normal.Z", "object.id")
    assert json.loads(spec.getattribute("ImageDescription"))["objects"] == list(expected.names)
    stored = file.read_image()
    file.close()
    np.testing.assert_array_equal(stored[..., 3], expected.depth.astype(np.float32))
    capsys.readouterr()
    assert main(["render", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "a.png"), "--layers"]) == 2
    assert "a.png holds no layers" in capsys.readouterr().err


def test_layers_that_cannot_be_written_are_named(tmp_path):
    pixels = np.zeros((2, 3, 3), np.float32)
    for path, layers, words in (
        ("a.exr", {"depth.Z": np.zeros((3, 2))}, r"'depth.Z' has shape \(3, 2\)"),
        ("a.exr", {"R": np.zeros((2, 3))}, "'R'; allowed is LAYER.CHANNEL"),
        ("a.png", {"depth.Z": np.zeros((2, 3))}, "holds no layers"),
    ):
        with pytest.raises(ImageError, match=words):
            dw.write_image(tmp_path / path, pixels, layers=layers)
    assert not list(tmp_path.iterdir())
