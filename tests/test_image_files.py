"""Image files: what is written comes back, and what is broken is an ImageError of one sentence."""

import json
import os
import struct
import zlib

import numpy as np
import OpenImageIO as oiio
import pytest

from diffwhitted.image import (
    ImageError,
    decode_from_display,
    encode_for_display,
    read_image,
    read_mask,
    write_image,
)

LINEAR = ["a.exr", "a.hdr", "a.tif"]
EVERY = [*LINEAR, "a.png", "a.jpg"]


def scene_light(height=6, width=9):
    """Positive light from 0.01 to 20, no two pixels alike."""
    levels = np.geomspace(0.01, 20, height * width * 3, dtype=np.float32)
    return np.random.default_rng(3).permutation(levels).reshape(height, width, 3)


def store(path, values, *, number=None, names=None, window=None, **attributes):
    """Writes raw numbers with OpenImageIO alone; window is x, y, then the full x, y, width, height."""
    values = np.ascontiguousarray(values)
    number = number or {"float32": "float"}.get(values.dtype.name, values.dtype.name)
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], number)
    if names:
        spec.channelnames = names
    if window:
        spec.x, spec.y, spec.full_x, spec.full_y, spec.full_width, spec.full_height = window
    for name, value in attributes.items():
        if isinstance(value, tuple):
            spec.attribute(name, oiio.TypeDesc(f"float[{len(value)}]"), value)
        else:
            spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(values) and output.close(), output.geterror()
    output.geterror()
    return path


def refusal(function, *arguments, **options):
    """The message of the ImageError that a call raises."""
    with pytest.raises(ImageError) as caught:
        function(*arguments, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{arguments[0]}: ")
    return message


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
            assert json.loads(spec.get_string_attribute("ImageDescription")) == {"scene": "two spheres"}
        if name == "a.exr":
            assert spec.getattribute("chromaticities") == pytest.approx(
                (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329), abs=1e-6
            )


# What other programs write is understood.


def test_codes_are_srgb_unless_the_file_says_linear(tmp_path):
    codes = np.full((1, 1, 3), 188, np.uint8)
    light = ((188 / 255 + 0.055) / 1.055) ** 2.4
    for name in ("a.png", "a.tif"):
        assert read_image(store(tmp_path / name, codes)).pixels[0, 0] == pytest.approx([light] * 3, rel=1e-6)
    linear = store(tmp_path / "l.png", codes, **{"oiio:ColorSpace": "lin_rec709_scene"})
    assert read_image(linear).pixels[0, 0] == pytest.approx([188 / 255] * 3, rel=1e-6)
    assert read_image(linear).colour_space == "linear Rec.709"


def test_other_colour_spaces_are_refused_not_guessed(tmp_path):
    pixels = scene_light()
    acescg = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
    assert "0.713" in refusal(read_image, store(tmp_path / "a.exr", pixels, chromaticities=acescg))
    named = store(tmp_path / "b.exr", pixels, **{"oiio:ColorSpace": "lin_ap1_scene"})
    assert "lin_ap1_scene" in refusal(read_image, named)


def test_grey_and_grey_with_alpha(tmp_path):
    codes = np.array([[[1000, 65535], [60000, 13107]]], np.uint16)
    grey = read_image(store(tmp_path / "g.png", codes[..., :1]))
    expected = decode_from_display(codes[..., [0, 0, 0]])
    np.testing.assert_array_equal(grey.pixels, expected)
    assert grey.alpha is None
    both = read_image(store(tmp_path / "ga.png", codes, **{"oiio:UnassociatedAlpha": 1}))
    np.testing.assert_array_equal(both.pixels, expected)
    np.testing.assert_allclose(both.alpha, [[1.0, 0.2]], rtol=1e-6)


def test_openexr_channels_are_found_by_name(tmp_path):
    values = np.broadcast_to(np.float32([1, 2, 3, 4, 5]), (2, 2, 5))
    layered = store(tmp_path / "a.exr", values, names=("Z", "key.B", "key.R", "key.G", "key.A"))
    back = read_image(layered)
    np.testing.assert_allclose(back.pixels[0, 0], [3 / 5, 4 / 5, 2 / 5], rtol=1e-6)
    assert back.alpha[0, 0] == 5


def test_several_layers_need_a_choice(tmp_path):
    values = np.broadcast_to(np.float32([1, 2, 3, 4, 5, 6]), (2, 2, 6))
    names = ("key.R", "key.G", "key.B", "fill.R", "fill.G", "fill.B")
    path = store(tmp_path / "a.exr", values, names=names)
    assert "'fill' or 'key'" in refusal(read_image, path)
    assert read_image(path, layer="fill").pixels[0, 0].tolist() == [4, 5, 6]
    assert "Y, BY, RY" in refusal(read_image, store(tmp_path / "y.exr", values[..., :3], names=("Y", "RY", "BY")))


def test_a_small_data_window_lies_in_its_place(tmp_path):
    path = store(tmp_path / "a.exr", np.full((2, 3, 3), 7, np.float32), window=(1, 2, 0, 0, 6, 5))
    back = read_image(path)
    expected = np.zeros((5, 6), np.float32)
    expected[2:4, 1:4] = 1
    np.testing.assert_array_equal(back.alpha, expected)
    np.testing.assert_array_equal(back.pixels, 7 * expected[..., None] * np.ones(3))
    assert "data window" in back.notes[0]


def test_a_large_data_window_is_cut(tmp_path):
    values = np.arange(72, dtype=np.float32).reshape(4, 6, 3)
    back = read_image(store(tmp_path / "a.exr", values, window=(-1, -1, 0, 0, 3, 2)))
    np.testing.assert_array_equal(back.pixels, values[1:3, 1:4])
    assert (back.alpha, back.notes) == (None, ())
    assert "in common" in refusal(read_image, store(tmp_path / "b.exr", values, window=(9, 9, 0, 0, 3, 2)))


@pytest.mark.parametrize(
    ("orientation", "turned"), [(3, [[4, 3], [2, 1]]), (5, [[1, 3], [2, 4]]), (6, [[3, 1], [4, 2]])]
)
def test_photographs_are_turned_upright(tmp_path, orientation, turned):
    values = np.float32([[1, 2], [3, 4]])[..., None] * np.ones(3, np.float32)
    path = store(tmp_path / "a.tif", values, Orientation=orientation)
    assert read_image(path).pixels[..., 0].tolist() == turned


def test_premultiplied_tiff(tmp_path):
    values = np.float32([[[0.2, 0.1, 0.4, 0.5], [0.3, 0.3, 0.3, 0.0]]])
    back = read_image(store(tmp_path / "a.tif", values))
    np.testing.assert_allclose(back.pixels, [[[0.4, 0.2, 0.8], [0.3, 0.3, 0.3]]], rtol=1e-6)


def test_the_first_of_several_images_is_read_and_said_so(tmp_path):
    path = str(tmp_path / "a.tif")
    spec = oiio.ImageSpec(2, 1, 3, "float")
    output = oiio.ImageOutput.create(path)
    assert output.open(path, spec) and output.write_image(np.full((1, 2, 3), 3, np.float32))
    assert output.open(path, spec, "AppendSubimage") and output.write_image(np.full((1, 2, 3), 9, np.float32))
    assert output.close()
    output.geterror()
    back = read_image(path)
    assert (back.pixels == 3).all()
    assert back.notes == ("Of several images in the file, the first was read.",)


# Masks.


def test_a_mask_is_not_colour_transformed(tmp_path):
    codes = np.array([[[0], [51], [255]]], np.uint8)
    np.testing.assert_allclose(read_mask(store(tmp_path / "m.png", codes)), [[0, 0.2, 1]], rtol=1e-6)
    alpha = np.array([[[255, 51], [255, 255]]], np.uint8)
    straight = store(tmp_path / "a.png", alpha, **{"oiio:UnassociatedAlpha": 1})
    np.testing.assert_allclose(read_mask(straight), [[0.2, 1]], rtol=1e-6)


def test_what_is_no_mask(tmp_path):
    colours = np.zeros((1, 2, 3), np.float32)
    colours[0, 0, 0] = 1
    assert "greyscale" in refusal(read_mask, store(tmp_path / "a.exr", colours))
    assert "row 0 and column 1" in refusal(read_mask, store(tmp_path / "b.exr", np.float32([[[1], [1.5]]])))
    assert "1 of 2" in refusal(read_mask, store(tmp_path / "c.exr", np.float32([[[1], [np.nan]]])))


# What cannot be read.


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("part", [0.0, 0.5, 0.97])
def test_files_cut_short(tmp_path, capfd, name, part):
    path = tmp_path / name
    write_image(path, np.random.default_rng(0).random((40, 40, 3)))
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    assert "cannot be read" in refusal(read_image, path)
    assert capfd.readouterr() == ("", "")


def test_silence_is_lifted_after_a_broken_png(tmp_path, capfd):
    (tmp_path / "a.png").write_bytes(b"\x89PNG nothing else")
    refusal(read_image, tmp_path / "a.png")
    os.write(2, b"heard")
    assert capfd.readouterr().err == "heard"


@pytest.mark.parametrize("name", EVERY)
def test_text_under_the_name_of_an_image(tmp_path, capfd, name):
    (tmp_path / name).write_text("no image at all, only words that go on for a while")
    assert "cannot be read" in refusal(read_image, tmp_path / name)
    assert capfd.readouterr() == ("", "")


def test_a_header_that_claims_too_much(tmp_path):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 12_000, 12_000, 8, 2, 0, 0, 0))
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", b"x") + chunk(b"IEND", b""))
    assert "12000 x 12000 pixels; allowed are 134217728" in refusal(read_image, tmp_path / "a.png")


def test_nothing_there_and_a_folder(tmp_path):
    assert "no such file" in refusal(read_image, tmp_path / "a.png")
    assert "not a file" in refusal(read_image, tmp_path)
    assert "cannot be read" in refusal(read_image, tmp_path / "a\0b.png")


def test_kinds_of_files_that_are_not_taken(tmp_path):
    assert "'bmp'" in refusal(read_image, store(tmp_path / "a.bmp", np.zeros((2, 2, 3), np.uint8)))
    assert "int16" in refusal(read_image, store(tmp_path / "a.tif", np.zeros((2, 2, 3), np.int16)))


# What cannot be written.


def test_extensions(tmp_path):
    for name in ("a.bmp", "a"):
        assert ".exr .hdr .tif .tiff .png .jpg .jpeg" in refusal(write_image, tmp_path / name, scene_light())


def test_folders(tmp_path):
    (tmp_path / "a.png").mkdir()
    assert "a folder" in refusal(write_image, tmp_path / "a.png", scene_light())
    assert "does not exist" in refusal(write_image, tmp_path / "none" / "a.png", scene_light())
    assert "too long" in refusal(write_image, tmp_path / ("a" * 300 + ".png"), scene_light())


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
