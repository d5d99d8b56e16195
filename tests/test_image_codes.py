"""What is known of the numbers in a file: their cells, how many measurements they are, which are none; and kinds."""

import struct

import numpy as np
import OpenImageIO as oiio
import pytest
from image_samples import gama, refusal, scene_light, store, store_png

from diffwhitted.image import (
    ImageError,
    decode_signal,
    display_codes,
    encode_for_display,
    encode_signal,
    read_image,
    without_bad_pixels,
    write_image,
)


def light(shape=(40, 30, 3), low=1e-4, high=1.05):
    return np.random.default_rng(5).uniform(low, high, shape)


# Cells.


@pytest.mark.parametrize(("bits", "name"), [(8, "a.png"), (16, "a.png"), (8, "a.tif"), (16, "a.tif"), (8, "a.bmp")])
def test_a_cell_is_all_light_that_is_stored_as_the_code(tmp_path, bits, name):
    true, largest = light(), 2**bits - 1
    codes = display_codes(true, bits)
    codes[0, 0] = 0
    low, high = read_image(store(tmp_path / name, codes)).cells
    inside = (low <= true) & (true <= high)
    assert inside[1:].all()
    np.testing.assert_array_equal(codes == 0, low == -np.inf)
    np.testing.assert_array_equal(codes == largest, high == np.inf)
    # Light at the edges of a cell is half a code away.
    middle = np.isfinite(low) & np.isfinite(high)
    signal = codes[middle] / largest
    np.testing.assert_allclose(encode_for_display(low[middle]), signal - 0.5 / largest, atol=1e-7)
    np.testing.assert_allclose(encode_for_display(high[middle]), signal + 0.5 / largest, atol=1e-7)


@pytest.mark.parametrize("encoding", ["linear", "rec709", "gamma:1.5"])
def test_cells_follow_the_encoding(tmp_path, encoding):
    true = light(high=0.99)
    codes = np.rint(encode_signal(true, encoding) * 255).astype(np.uint8)
    read = read_image(store_png(tmp_path / "a.png", codes), encoding=encoding)
    low, high = read.cells
    assert ((low <= true + 1e-12) & (true <= high + 1e-12)).all()
    inner = (codes > 0) & (codes < 255)
    np.testing.assert_allclose(read.step[inner], (high - low)[inner], rtol=1e-12)


def test_codes_of_fewer_bits(tmp_path):
    """OpenImageIO spreads 2 bits over 8; a cell is still as wide as a code of two."""
    codes = np.uint8([[[0], [1], [2], [3]]])
    read = read_image(store_png(tmp_path / "a.png", codes, gama(100_000), bits=2))
    np.testing.assert_allclose(read.pixels[0, :, 0], [0, 1 / 3, 2 / 3, 1], rtol=1e-6)
    low, high = read.cells
    np.testing.assert_allclose(low[0, :, 0], [-np.inf, 1 / 6, 3 / 6, 5 / 6])
    np.testing.assert_allclose(high[0, :, 0], [1 / 6, 3 / 6, 5 / 6, np.inf])
    np.testing.assert_allclose(read.step, 1 / 3)


def test_cells_of_half_floats_reach_halfway_to_the_next(tmp_path):
    pixels = np.array([[[1.0, 0.3, 65504.0], [0.0, -2.0, 100.0]]])
    write_image(tmp_path / "a.exr", pixels, half=True)
    read = read_image(tmp_path / "a.exr")
    low, high = read.cells
    # 11 bits: numbers below 1 lie 2^-11 apart, those above 2^-10.
    assert (low[0, 0, 0], high[0, 0, 0]) == (1 - 2**-12, 1 + 2**-11)
    assert (low[0, 1, 0], high[0, 1, 0]) == (-(2.0**-25), 2.0**-25)
    assert (high[0, 0, 2], low[0, 0, 2]) == (np.inf, 65504 - 16)
    assert read.step[0, 1, 2] == 2**-4
    stored = low[..., 1] / 2 + high[..., 1] / 2
    np.testing.assert_allclose(stored, read.pixels[..., 1], rtol=1e-3)


def test_where_no_cells_are_known(tmp_path):
    write_image(tmp_path / "a.exr", scene_light())
    write_image(tmp_path / "a.jpg", scene_light(16, 16))
    for name in ("a.exr", "a.jpg"):
        assert read_image(tmp_path / name).cells is None
    assert read_image(tmp_path / "a.exr").step is None
    codes = np.full((1, 2, 4), 100, np.uint8)
    straight = read_image(store(tmp_path / "a.png", codes, **{"oiio:UnassociatedAlpha": 1}))
    assert straight.cells is not None
    premultiplied = read_image(store(tmp_path / "a.tif", codes))
    assert premultiplied.cells is None
    # D((c + 1/2) / a) - D((c - 1/2) / a) with a = 100/255.
    edges = decode_signal(np.array([99.5, 100.5]) / 100, "srgb")
    np.testing.assert_allclose(premultiplied.step, edges[1] - edges[0], rtol=1e-6)


def test_lossy_files_have_the_width_of_a_code_all_the_same(tmp_path):
    for name in ("a.jpg", "a.webp"):
        read = read_image(store(tmp_path / name, np.full((16, 16, 3), 188, np.uint8)))
        assert read.lossy and read.cells is None
        code = np.rint(encode_for_display(read.pixels) * 255)
        edges = decode_signal((code[..., None] + [-0.5, 0.5]) / 255, "srgb")
        np.testing.assert_allclose(read.step, edges[..., 1] - edges[..., 0], rtol=1e-6)
    assert not read_image(store(tmp_path / "a.png", np.zeros((1, 1, 3), np.uint8))).lossy


def test_the_width_of_a_radiance_code_is_that_of_the_brightest_channel(tmp_path):
    write_image(tmp_path / "a.hdr", np.array([[[1.0, 0.25, 0.125], [100.0, 3.0, 2.0]]]))
    read = read_image(tmp_path / "a.hdr")
    # Mantissas of 8 bits: 1 = 128/128, 100 = 200/2.
    np.testing.assert_allclose(read.step[0], [[1 / 128] * 3, [1 / 2] * 3])
    assert read.cells is None
    head = b"#?RADIANCE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n"
    (tmp_path / "b.hdr").write_bytes(head + bytes([128, 64, 32, 129]))
    exposed = read_image(tmp_path / "b.hdr")
    np.testing.assert_allclose(exposed.pixels[0, 0], [1 / 2, 1 / 4, 1 / 8])
    np.testing.assert_allclose(exposed.step, 1 / 256)


def test_the_width_of_a_code_through_a_matrix_of_primaries(tmp_path):
    """Adobe RGB (1998): red is 1.39836 r - 0.39836 g, green is g."""
    numbers = (0.3127, 0.329, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06)
    adobe = b"cHRM", struct.pack(">8I", *(round(number * 100_000) for number in numbers))
    read = read_image(store_png(tmp_path / "a.png", np.uint8([[[9, 90, 200]]]), gama(100_000), adobe))
    expected = [np.hypot(1.39836, 0.39836) / 255, 1 / 255, np.hypot(0.04293, 1.04293) / 255]
    np.testing.assert_allclose(read.step[0, 0], expected, rtol=1e-4)


def test_alpha_of_a_bmp_is_straight(tmp_path):
    codes = np.uint8([[[10, 100, 200, 51]]])
    read = read_image(store(tmp_path / "a.bmp", codes, **{"oiio:UnassociatedAlpha": 1}), encoding="linear")
    np.testing.assert_allclose(read.pixels[0, 0] * 255, [10, 100, 200], rtol=1e-6)
    assert read.alpha[0, 0] == np.float32(0.2)


def test_a_picture_of_few_colours_is_lossy(tmp_path):
    header = struct.pack("<BBBHHBHHHHBB", 0, 1, 1, 0, 2, 24, 0, 0, 2, 1, 8, 0x20)
    (tmp_path / "a.tga").write_bytes(header + bytes([10, 20, 30, 70, 80, 90]) + bytes([0, 1]))
    read = read_image(tmp_path / "a.tga")
    assert read.lossy and read.cells is None
    np.testing.assert_allclose(read.pixels, decode_signal(np.array([[[30, 20, 10], [90, 80, 70]]]) / 255, "srgb"), 1e-6)


# One measurement or three.


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.jpg", "a.exr"])
def test_grey_counts_as_one_measurement(tmp_path, name):
    grey = light((16, 16, 1), high=0.9)
    if name == "a.exr":
        one, three = grey.astype(np.float32), np.float32(grey) * np.ones(3, np.float32)
    else:
        one = np.rint(grey * 255).astype(np.uint8)
        three = one * np.ones(3, np.uint8)
    assert read_image(store(tmp_path / name, one)).monochrome
    assert read_image(store(tmp_path / name, three)).monochrome
    three[3, 4, 1] = 0
    three[:8] = three[3, 4]
    assert not read_image(store(tmp_path / name, three)).monochrome


# Pixels that are no numbers.


def test_pixels_that_are_no_numbers_leave_the_mask():
    pixels = np.ones((3, 4, 3))
    pixels[0, 1, 2] = np.nan
    pixels[2, 3] = np.inf
    pixels[1, 0, 0] = -np.inf
    mask, count = without_bad_pixels(pixels)
    assert count == 3 and mask.sum() == 9 and mask[0, 1] == mask[2, 3] == mask[1, 0] == 0
    given = np.full((3, 4), 0.5)
    given[2] = 0
    mask, count = without_bad_pixels(pixels, given)
    assert count == 2 and mask.sum() == 0.5 * 6 and given[0, 1] == 0.5
    with pytest.raises(ImageError, match=r"shape \(4, 3\); allowed is \(3, 4\)"):
        without_bad_pixels(pixels, given.T)


# Kinds of files.


@pytest.mark.parametrize("corner", [0x00, 0x10, 0x20, 0x30])
def test_targa_from_any_corner_is_upright(tmp_path, corner):
    rows = np.uint8([[10, 20, 30], [40, 50, 60]])
    stored = rows[:: 1 if corner & 0x20 else -1, :: -1 if corner & 0x10 else 1]
    header = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, 3, 2, 24, corner)
    (tmp_path / "a.tga").write_bytes(header + np.repeat(stored, 3).tobytes())
    read = read_image(tmp_path / "a.tga", encoding="linear")
    np.testing.assert_allclose(read.pixels[..., 0] * 255, rows, rtol=1e-6)


@pytest.mark.parametrize("kind", ["tga", "bmp", "gif", "ppm", "sgi", "dpx", "rla"])
def test_kinds_that_keep_codes(tmp_path, kind):
    codes = np.uint8([[[0, 40, 90], [255, 128, 1]]])
    np.testing.assert_allclose(
        read_image(store(tmp_path / f"a.{kind}", codes)).pixels, decode_signal(codes / 255, "srgb"), 1e-6
    )


def test_a_file_that_cannot_say_how_it_is_encoded_says_so(tmp_path):
    path = store(tmp_path / "a.ppm", np.uint8([[[128] * 3]]))
    assert "does not say" in read_image(path).notes[0]
    assert read_image(path, encoding="rec709").notes == ()
    assert "does not say" in read_image(store_png(tmp_path / "a.png", np.uint16([[[128]]]))).notes[0]
    for name, codes, chunks in (("b.png", np.uint8([[[128]]]), []), ("c.png", np.uint16([[[128]]]), [gama(45455)])):
        assert read_image(store_png(tmp_path / name, codes, *chunks)).notes == ()
    floats = store(tmp_path / "a.pfm", scene_light())
    np.testing.assert_array_equal(read_image(floats).pixels, scene_light())
    assert read_image(floats).notes == ()


def test_what_is_no_flat_picture_is_refused_with_a_way_out(tmp_path):
    (tmp_path / "a.NEF").write_bytes(b"II*\0 a raw file is a TIFF of another kind")
    assert "dcraw -4 -T or rawpy" in refusal(read_image, tmp_path / "a.NEF")
    (tmp_path / "a.null").write_bytes(b"nothing")
    assert "no light" in refusal(read_image, tmp_path / "a.null")
    deep = oiio.ImageSpec(1, 1, 4, "float")
    deep.channelnames = ("R", "G", "B", "A")
    deep.deep = True
    data = oiio.DeepData()
    data.init(1, 4, deep.format, deep.channelnames)
    output = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert output.open(str(tmp_path / "a.exr"), deep) and output.write_deep_image(data) and output.close()
    assert "oiiotool --flatten" in refusal(read_image, tmp_path / "a.exr")
