"""Image files written: what is written comes back, and what cannot be is an ImageError of one sentence."""

import json
import os

import numpy as np
import OpenImageIO as oiio
import pytest
from image_samples import EVERY, LINEAR, refusal, scene_light

from diffwhitted.image import check_writable, encode_for_display, read_image, write_image

# What is written comes back.


@pytest.mark.parametrize("name", ["a.exr", "a.tif", "A.EXR"])
def test_floats_come_back_exactly(tmp_path, name):
    pixels = scene_light()
    pixels[0, 0] = [-1.5, np.nan, np.inf]
    write_image(tmp_path / name, pixels)
    back = read_image(tmp_path / name)
    np.testing.assert_array_equal(back.pixels, pixels)
    assert back.pixels.dtype == np.float32
    assert (back.alpha, back.colour_space, back.path) == (None, "linear Rec.709", tmp_path / name)


@pytest.mark.parametrize("name", ["a.exr", "a.hdr", "a.png"])
def test_the_order_of_the_pixels_in_memory_does_not_matter(tmp_path, name):
    pixels = scene_light()
    write_image(tmp_path / name, pixels)
    write_image(tmp_path / f"b{name}", np.asfortranarray(pixels))
    np.testing.assert_array_equal(read_image(tmp_path / f"b{name}").pixels, read_image(tmp_path / name).pixels)


def test_half_floats_keep_eleven_bits(tmp_path):
    pixels = scene_light()
    write_image(tmp_path / "a.exr", pixels, half=True)
    np.testing.assert_array_equal(read_image(tmp_path / "a.exr").pixels, pixels.astype(np.float16))


def test_radiance_shares_an_exponent_of_eight_bit_mantissas(tmp_path):
    pixels = scene_light()
    write_image(tmp_path / "a.hdr", pixels)
    error = np.abs(read_image(tmp_path / "a.hdr").pixels - pixels)
    # A mantissa in [128, 256) for the largest channel: a step is at most 1/128 of it.
    assert (error <= pixels.max(axis=2, keepdims=True) / 128).all()
    assert error.max() > 0


def test_png_keeps_sixteen_bits_of_the_display_signal(tmp_path):
    pixels = scene_light()
    write_image(tmp_path / "a.png", pixels, exposure=-5.0)
    back = read_image(tmp_path / "a.png")
    signal = encode_for_display(pixels, exposure=-5.0)
    assert np.abs(encode_for_display(back.pixels) - signal).max() <= 0.5001 / 65535
    assert back.colour_space == "sRGB"


def test_jpeg_of_one_colour(tmp_path):
    pixels = np.full((8, 8, 3), [0.2, 0.5, 0.8])
    write_image(tmp_path / "a.jpg", pixels)
    signal = encode_for_display(read_image(tmp_path / "a.jpg").pixels)
    assert np.abs(signal - encode_for_display(pixels)).max() < 2 / 255


def test_row_0_is_on_top_and_red_comes_first(tmp_path):
    pixels = np.zeros((8, 16, 3), np.float32)
    pixels[0, :, 0] = 1
    for name in EVERY:
        write_image(tmp_path / name, pixels)
        back = read_image(tmp_path / name).pixels
        assert back.shape == (8, 16, 3)
        assert back[0, 8, 0] > 0.9 > 0.2 > back[7, 8, 0]
        assert back[0, 8, 1] < 0.1


def test_alpha_comes_back_straight(tmp_path):
    pixels = scene_light()
    alpha = np.linspace(0, 1, 54, dtype=np.float32).reshape(6, 9)
    for name, tolerance in (("a.exr", 1e-6), ("a.tif", 0), ("a.png", 3e-5)):
        write_image(tmp_path / name, pixels / 20, alpha=alpha)
        back = read_image(tmp_path / name)
        np.testing.assert_allclose(back.alpha, alpha, atol=1e-5)
        np.testing.assert_allclose(back.pixels[alpha > 0], pixels[alpha > 0] / 20, rtol=1e-6, atol=tolerance)


def test_openexr_stores_premultiplied_colour(tmp_path):
    write_image(tmp_path / "a.exr", np.full((1, 2, 3), 0.8), alpha=np.array([[0.25, 0.0]]))
    source = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    np.testing.assert_allclose(source.read_image(), [[[0.2, 0.2, 0.2, 0.25], [0, 0, 0, 0]]], rtol=1e-6)


def test_files_say_what_they_are(tmp_path):
    for name in EVERY:
        write_image(tmp_path / name, np.zeros((2, 2, 3)), metadata={"Software": "ray 1.0", "scene": "two spheres"})
        spec = oiio.ImageInput.open(str(tmp_path / name)).spec()
        space = spec.get_string_attribute("oiio:ColorSpace")
        assert space == {"a.tif": ""}.get(name, "lin_rec709_scene" if name in LINEAR else "srgb_rec709_scene")
        if name != "a.hdr":
            assert spec.get_string_attribute("Software") == "ray 1.0"
            stated = {"oiio:ColorSpace": "lin_rec709_scene"} if name == "a.tif" else {}
            assert json.loads(spec.get_string_attribute("ImageDescription")) == {"scene": "two spheres"} | stated
        if name == "a.exr":
            assert spec.getattribute("chromaticities") == pytest.approx(
                (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329), abs=1e-6
            )


# What cannot be written.


def test_extensions(tmp_path):
    for name in ("a.bmp", "a"):
        assert ".exr .hdr .tif .tiff .png .jpg .jpeg" in refusal(write_image, tmp_path / name, scene_light())


def test_folders(tmp_path):
    (tmp_path / "a.png").mkdir()
    assert "a folder" in refusal(write_image, tmp_path / "a.png", scene_light())
    assert "does not exist" in refusal(write_image, tmp_path / "none" / "a.png", scene_light())
    assert "too long" in refusal(write_image, tmp_path / ("a" * 300 + ".png"), scene_light())


def test_a_place_is_checked_before_there_are_pixels(tmp_path):
    assert (check_writable(tmp_path / "a.png", exposure=1.0).bits, check_writable(tmp_path / "a.exr").bits) == (16, 0)
    for name, options in (
        ("a.bmp", {}),
        ("none/a.png", {}),
        ("a.exr", {"exposure": 1.0}),
        ("a.png", {"exposure": 99.0}),
    ):
        before = refusal(check_writable, tmp_path / name, **options)
        assert before == refusal(write_image, tmp_path / name, scene_light(), **options)
    assert list(tmp_path.iterdir()) == []


def test_no_permission_to_write(tmp_path, monkeypatch):
    path = tmp_path / "a.exr"
    path.write_bytes(b"the old file")
    for refused in (path, tmp_path):
        monkeypatch.setattr(os, "access", lambda place, mode, refused=refused: place != refused)
        assert "permission" in refusal(write_image, path, scene_light())
    assert path.read_bytes() == b"the old file"


@pytest.mark.parametrize(
    ("pixels", "said"),
    [
        (np.zeros((4, 4)), r"(4, 4)"),
        (np.zeros((4, 4, 4)), r"(4, 4, 4)"),
        (np.zeros((0, 4, 3)), r"(0, 4, 3)"),
        (np.zeros((4, 4, 3), np.uint8), "uint8"),
    ],
)
def test_pixels_of_a_wrong_kind(tmp_path, pixels, said):
    assert said in refusal(write_image, tmp_path / "a.jpg", pixels)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "side"), [("a.jpg", 65_500), ("a.png", 1_000_000)])
def test_images_wider_than_a_format_allows(tmp_path, capfd, name, side):
    pixels = np.broadcast_to(np.float32(0.5), (1, side + 1, 3))
    assert f"at most {side} a side" in refusal(write_image, tmp_path / name, pixels)
    assert capfd.readouterr() == ("", "")


def test_values_that_a_format_cannot_hold(tmp_path):
    pixels = scene_light()
    pixels[2, 5, 1] = np.nan
    for name in ("a.hdr", "a.png", "a.jpg"):
        assert "1 of 54 pixels, the first in row 2 and column 5" in refusal(write_image, tmp_path / name, pixels)
    pixels[2, 5, 1] = -1e-3
    assert "outside [0," in refusal(write_image, tmp_path / "a.hdr", pixels)
    pixels[2, 5, 1] = 7e4
    assert "65504" in refusal(write_image, tmp_path / "a.exr", pixels, half=True)
    assert "3.40282e+38" in refusal(write_image, tmp_path / "a.exr", np.full((1, 1, 3), 1e39))


def test_options_that_a_format_does_not_have(tmp_path):
    pixels, alpha = scene_light(), np.ones((6, 9))
    assert "half" in refusal(write_image, tmp_path / "a.png", pixels, half=True)
    assert "exposure = 1.0" in refusal(write_image, tmp_path / "a.exr", pixels, exposure=1.0)
    assert "64 stops" in refusal(write_image, tmp_path / "a.png", pixels, exposure=1e3)
    assert "no alpha" in refusal(write_image, tmp_path / "a.jpg", pixels, alpha=alpha)
    assert "alpha of shape (3, 9)" in refusal(write_image, tmp_path / "a.png", pixels, alpha=alpha[:3])
    assert "alpha outside" in refusal(write_image, tmp_path / "a.exr", pixels, alpha=2 * alpha)
    assert "60000" in refusal(write_image, tmp_path / "a.jpg", pixels, metadata={"scene": "x" * 60_000})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a.exr", "a.hdr", "a.tif", "a.png"])
def test_a_write_that_fails_halfway_leaves_everything_as_it_was(tmp_path, capfd, name):
    resource = pytest.importorskip("resource")
    (tmp_path / name).write_bytes(b"the old file")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        message = refusal(write_image, tmp_path / name, np.random.default_rng(0).random((70, 70, 3)))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "cannot be written" in message
    assert (tmp_path / name).read_bytes() == b"the old file"
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert capfd.readouterr() == ("", "")


def test_an_interrupted_write_leaves_everything_as_it_was(tmp_path, monkeypatch):
    def interrupted(source, target):
        assert os.path.getsize(source) > 0
        raise KeyboardInterrupt

    (tmp_path / "a.exr").write_bytes(b"the old file")
    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_image(tmp_path / "a.exr", scene_light())
    assert (tmp_path / "a.exr").read_bytes() == b"the old file"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_full_disk_is_noticed_before_libjpeg_ends_the_program(tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda folder: type("Usage", (), {"free": 1000}))
    assert "disk" in refusal(write_image, tmp_path / "a.jpg", scene_light())


def test_writing_through_a_link_keeps_the_link(tmp_path):
    write_image(tmp_path / "real.exr", np.zeros((1, 1, 3)))
    (tmp_path / "link.exr").symlink_to(tmp_path / "real.exr")
    write_image(tmp_path / "link.exr", np.ones((1, 1, 3)))
    assert (tmp_path / "link.exr").is_symlink()
    assert read_image(tmp_path / "real.exr").pixels[0, 0, 0] == 1
