"""How the numbers of a file stand for light: curves and primaries, as the file says or as a person does."""

import struct

import numpy as np
import pytest
from image_samples import gama, iccp, power_curve, profile, refusal, store, store_png, table_curve

from diffwhitted import InputError
from diffwhitted.image import checked_encoding, decode_signal, encode_signal, read_image

SRGB = (b"sRGB", b"\0")
CODES = np.uint16([[[0, 1000, 5000], [20000, 40000, 65535]]])
SIGNAL = CODES / 65535

ADOBE = [(0.60974, 0.31111, 0.01947), (0.20528, 0.62567, 0.06087), (0.14919, 0.06322, 0.74457)]
"""X, Y, Z of the primaries of Adobe RGB (1998) relative to D50, as in Adobe's profile."""
FROM_ADOBE = np.array([[1.39836, -0.39836, 0], [0, 1, 0], [0, -0.04293, 1.04293]])
"""From linear Adobe RGB (1998) to linear sRGB, both of D65 (Lindbloom)."""
REC709 = [(0.4360747, 0.2225045, 0.0139322), (0.3850649, 0.7168786, 0.0971045), (0.1430804, 0.0606169, 0.7141733)]
"""X, Y, Z of the primaries of sRGB relative to D50 (Lindbloom)."""


def srgb(signal):
    """IEC 61966-2-1."""
    return np.where(signal <= 0.04045, signal / 12.92, ((signal + 0.055) / 1.055) ** 2.4)


# Encodings by name.


def test_each_encoding_by_its_formula_and_back():
    signal = np.linspace(0, 1.2, 25)
    expected = {
        "linear": signal,
        "srgb": srgb(signal),
        "rec709": np.where(signal < 0.0812, signal / 4.5, ((signal + 0.099) / 1.099) ** (1 / 0.45)),
        "gamma:2.2": signal**2.2,
        "gamma:0.5": signal**0.5,
    }
    for encoding, light in expected.items():
        np.testing.assert_allclose(decode_signal(signal, encoding), light, rtol=1e-7, atol=1e-9)
    for encoding in (*expected, "cineon"):
        np.testing.assert_allclose(encode_signal(decode_signal(signal, encoding), encoding), signal, atol=1e-5)
    # White of Kodak's film scale is code 685 of 1023, black code 95.
    np.testing.assert_allclose(decode_signal(np.array([95, 685]) / 1023, "cineon"), [0, 1], atol=1e-9)
    assert decode_signal(np.array([-0.5]), "gamma:2")[0] == -0.25


def test_names_of_encodings():
    assert [checked_encoding(name) for name in ("sRGB", " Linear", "Gamma:2.20", "gamma:1")] == [
        "srgb",
        "linear",
        "gamma:2.2",
        "linear",
    ]
    for wrong in ("gamma", "gamma:", "gamma:0", "gamma:-2", "gamma:nan", "gamma:inf", "rec2020", ""):
        with pytest.raises(InputError, match=r"allowed are linear, srgb, rec709, cineon and gamma:NUMBER"):
            checked_encoding(wrong)


def test_a_person_may_say_how_the_file_is_encoded(tmp_path):
    path = store_png(tmp_path / "a.png", CODES)
    for encoding, light in {"linear": SIGNAL, "gamma:2": SIGNAL**2, None: srgb(SIGNAL)}.items():
        read = read_image(path, encoding=encoding)
        np.testing.assert_allclose(read.pixels, light, rtol=1e-6)
        assert read.encoding == (encoding or "srgb")
    floats = store(tmp_path / "a.exr", SIGNAL.astype(np.float32))
    np.testing.assert_allclose(read_image(floats, encoding="srgb").pixels, srgb(SIGNAL), rtol=1e-5)
    with pytest.raises(InputError, match=r"encoding = 'sgrb'"):
        read_image(path, encoding="sgrb")


# PNG, third edition, section 4.3: iCCP before sRGB before gAMA and cHRM.


@pytest.mark.parametrize(
    ("chunks", "light"),
    [
        ([], srgb(SIGNAL)),
        ([SRGB], srgb(SIGNAL)),
        ([gama(45455)], SIGNAL ** (1 / 0.45455)),
        ([gama(100000)], SIGNAL),
        ([gama(66667)], SIGNAL ** (1 / 0.66667)),
        ([SRGB, gama(100000)], srgb(SIGNAL)),
        ([gama(100000), SRGB], srgb(SIGNAL)),
        ([iccp(profile(REC709, [power_curve(1.5)] * 3)), gama(100000)], SIGNAL**1.5),
        ([gama(0)], srgb(SIGNAL)),
    ],
)
def test_the_curve_that_a_png_states(tmp_path, chunks, light):
    np.testing.assert_allclose(read_image(store_png(tmp_path / "a.png", CODES, *chunks)).pixels, light, rtol=5e-6)


def test_the_primaries_that_a_png_states(tmp_path):
    numbers = (0.3127, 0.329, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06)
    adobe = b"cHRM", struct.pack(">8I", *(round(number * 100_000) for number in numbers))
    codes = np.uint16([[[65535, 0, 0], [0, 65535, 0], [0, 0, 65535], [65535] * 3, [40000, 30000, 20000]]])
    read = read_image(store_png(tmp_path / "a.png", codes, gama(100_000), adobe))
    np.testing.assert_allclose(read.pixels, codes / 65535 @ FROM_ADOBE.T, atol=2e-5)
    assert not read.monochrome and read.cells is None
    # With sRGB they do not count, and white is white.
    stated = read_image(store_png(tmp_path / "b.png", codes, (b"sRGB", b"\0"), adobe)).pixels
    np.testing.assert_allclose(stated, srgb(codes / 65535), rtol=1e-6)
    none = b"cHRM", struct.pack(">8I", *[30000] * 8)
    assert "no mixture" in refusal(read_image, store_png(tmp_path / "c.png", codes, none))


# ICC profiles.


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.jpg"])
def test_a_profile_of_a_matrix_and_curves(tmp_path, name):
    flat = np.full((8, 8, 3), (200, 120, 60), np.uint8)
    data = np.frombuffer(profile(ADOBE, [power_curve(563 / 256)] * 3), np.uint8)
    path = tmp_path / name
    if name == "a.png":
        store_png(path, flat, iccp(data.tobytes()))
    else:
        store(path, flat, ICCProfile=data)
    read = read_image(path)
    signal = np.array([200, 120, 60]) / 255
    expected = FROM_ADOBE @ signal ** (563 / 256)
    np.testing.assert_allclose(read.pixels[3, 3], expected, atol=0.03 if name == "a.jpg" else 1e-4)
    assert read.encoding == "gamma:2.19922" and read.notes == ()


def test_curves_of_a_profile(tmp_path):
    points = np.linspace(0, 1, 1024)
    parametric = [2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045]
    curves = {
        "srgb": table_curve(srgb(points)),
        "linear": struct.pack(">4s4xI", b"curv", 0),
        "rec709": table_curve(decode_signal(points, "rec709")),
    }
    for encoding, curve in curves.items():
        read = read_image(store_png(tmp_path / "a.png", CODES, iccp(profile(REC709, [curve] * 3))))
        assert (read.encoding, read.cells is not None) == (encoding, True)
        np.testing.assert_allclose(read.pixels, decode_signal(SIGNAL, encoding), rtol=1e-6)
    para = struct.pack(">4s4xH2x5i", b"para", 3, *(round(number * 65536) for number in parametric))
    assert read_image(store_png(tmp_path / "b.png", CODES, iccp(profile(REC709, [para] * 3)))).encoding == "srgb"
    # Curves without a name, one for each channel.
    own = [table_curve(shape) for shape in (points**3 * 0.9 + points * 0.1, points, points**2)]
    read = read_image(store_png(tmp_path / "c.png", CODES, iccp(profile(REC709, own))))
    expected = np.stack([SIGNAL[..., 0] ** 3 * 0.9 + SIGNAL[..., 0] * 0.1, SIGNAL[..., 1], SIGNAL[..., 2] ** 2], -1)
    np.testing.assert_allclose(read.pixels, expected, atol=2e-5)
    low, high = read.cells
    assert read.encoding is None and ((low < read.pixels) & (read.pixels < high)).all()


def test_a_profile_that_is_not_read_is_said(tmp_path):
    for data in (profile(REC709, [power_curve(1.5)] * 3, connection=b"Lab "), profile(REC709, [b"nothing"] * 3)):
        read = read_image(store(tmp_path / "a.tif", CODES, ICCProfile=np.frombuffer(data, np.uint8)))
        np.testing.assert_allclose(read.pixels, srgb(SIGNAL), rtol=1e-6)
        assert "was not applied" in read.notes[0]


# Primaries of OpenEXR, and spaces by their names.


def test_other_primaries_become_rec709(tmp_path):
    acescg = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
    # Bradford from AP1 (D60) to Rec.709 (D65), as printed in many a shader.
    matrix = [[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055], [-0.02400, -0.12897, 1.15297]]
    values = np.float32([[[1, 0, 0], [0, 1, 0], [0, 0, 1], [5, 5, 5], [0.2, 0.5, 0.3]]])
    expected = values @ np.transpose(matrix)
    tagged = read_image(store(tmp_path / "a.exr", values, chromaticities=acescg))
    np.testing.assert_allclose(tagged.pixels, expected, atol=2e-4)
    np.testing.assert_allclose(tagged.pixels[0, 3], 5, rtol=1e-6)
    named = read_image(store(tmp_path / "b.exr", values, **{"oiio:ColorSpace": "lin_ap1_scene"}))
    np.testing.assert_allclose(named.pixels, expected, atol=2e-4)
    p3 = [[1.22494, -0.22494, 0], [-0.04206, 1.04206, 0], [-0.01964, -0.07864, 1.09827]]
    coded = store(tmp_path / "c.png", CODES, **{"oiio:ColorSpace": "srgb_p3d65_scene"})
    np.testing.assert_allclose(read_image(coded).pixels, srgb(SIGNAL) @ np.transpose(p3), atol=2e-5)


def test_grey_stays_grey_in_any_primaries(tmp_path):
    acescg = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
    grey = np.float32([[[0.1] * 3, [0.7] * 3]])
    read = read_image(store(tmp_path / "a.exr", grey, chromaticities=acescg))
    np.testing.assert_array_equal(read.pixels, grey)
    assert read.monochrome
    codes = np.uint8([[[40] * 3, [200] * 3]])
    tagged = read_image(store_png(tmp_path / "a.png", codes, iccp(profile(ADOBE, [power_curve(2)] * 3))))
    low, high = tagged.cells
    np.testing.assert_allclose(low, ((codes - 0.5) / 255) ** 2)
    np.testing.assert_allclose(tagged.step, high - low)
