"""Image files read: what other programs write is understood, and what is broken is an ImageError of one sentence."""

import os
import struct

import numpy as np
import OpenImageIO as oiio
import pytest
from image_samples import EVERY, chunk, refusal, scene_light, store

from diffwhitted.image import decode_from_display, read_image, read_mask, write_image

# What other programs write is understood.


def test_codes_are_srgb_unless_the_file_says_linear(tmp_path):
    codes = np.full((1, 1, 3), 188, np.uint8)
    light = ((188 / 255 + 0.055) / 1.055) ** 2.4
    for name in ("a.png", "a.tif"):
        assert read_image(store(tmp_path / name, codes)).pixels[0, 0] == pytest.approx([light] * 3, rel=1e-6)
    linear = store(tmp_path / "l.png", codes, **{"oiio:ColorSpace": "lin_rec709_scene"})
    assert read_image(linear).pixels[0, 0] == pytest.approx([188 / 255] * 3, rel=1e-6)
    assert read_image(linear).colour_space == "linear Rec.709"


def test_a_colour_space_without_a_meaning_is_refused_not_guessed(tmp_path):
    path = store(tmp_path / "a.exr", scene_light(), colorInteropID="lin_martian_scene")
    assert "lin_martian_scene" in refusal(read_image, path)
    np.testing.assert_array_equal(read_image(path, encoding="linear").pixels, scene_light())


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
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 12_000, 12_000, 8, 2, 0, 0, 0))
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", b"x") + chunk(b"IEND", b""))
    assert "12000 x 12000 pixels; allowed are 134217728" in refusal(read_image, tmp_path / "a.png")


def test_nothing_there_and_a_folder(tmp_path):
    assert "no such file" in refusal(read_image, tmp_path / "a.png")
    assert "not a file" in refusal(read_image, tmp_path)
    assert "cannot be read" in refusal(read_image, tmp_path / "a\0b.png")


def test_kinds_of_files_that_are_not_taken(tmp_path):
    assert "int16" in refusal(read_image, store(tmp_path / "a.tif", np.zeros((2, 2, 3), np.int16)))
