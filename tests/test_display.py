"""The display transform against IEC 61966-2-1, and CIEDE2000 against the published pairs."""

import subprocess
import sys

import numpy as np
import pytest

from diffwhitted.image import ciede2000, count_clipped, decode_from_display, display_codes, encode_for_display
from diffwhitted.image._colour import decode_srgb, encode_srgb, lab, lab_difference


# IEC 61966-2-1: the straight part ends at 0.0031308; above it 1.055 L^(1/2.4) - 0.055.
@pytest.mark.parametrize(
    ("linear", "signal"), [(0.0, 0.0), (0.0031308, 0.0031308 * 12.92), (0.18, 0.461356), (0.5, 0.735357), (1.0, 1.0)]
)
def test_srgb_values(linear, signal):
    assert encode_for_display(np.array([linear])) == pytest.approx([signal], abs=5e-7)


def test_srgb_has_its_two_parts_on_either_side_of_the_threshold():
    below, above = encode_srgb(np.array([0.003, 0.0032]))
    assert below == pytest.approx(12.92 * 0.003, rel=1e-12)
    assert above == pytest.approx(1.055 * 0.0032 ** (1 / 2.4) - 0.055, rel=1e-12)
    assert above < 12.92 * 0.0032


def test_decoding_undoes_encoding_also_outside_the_display():
    light = np.array([-0.2, 0.0, 0.001, 0.3, 1.0, 7.0])
    np.testing.assert_allclose(decode_srgb(encode_srgb(light)), light, rtol=1e-6)
    assert encode_srgb(light)[-1] > 1


@pytest.mark.parametrize("bits", [8, 16])
def test_every_code_comes_back(bits):
    codes = np.arange(2**bits).astype(f"uint{bits}")
    light = decode_from_display(codes)
    assert light.dtype == np.float32
    assert (np.diff(light) > 0).all()
    np.testing.assert_array_equal(display_codes(light, bits), codes)


def test_middle_code_of_eight_bits():
    # ((188/255 + 0.055) / 1.055)^2.4
    assert decode_from_display(np.uint8([188]))[0] == pytest.approx(0.502886, abs=1e-6)


def test_exposure_counts_in_stops_and_comes_before_clipping():
    light = np.array([0.125, 0.5, 2.0])
    np.testing.assert_allclose(encode_for_display(light, exposure=1.0), encode_for_display(light * 2))
    assert encode_for_display(light, exposure=-2.0)[2] == pytest.approx(0.735357, abs=5e-7)


def test_clipping_keeps_what_is_not_a_number():
    shown = encode_for_display(np.array([-1.0, np.nan, np.inf]))
    np.testing.assert_allclose(shown, [0.0, np.nan, 1.0], rtol=1e-15)


def test_clipped_pixels_are_counted_as_pixels():
    light = np.full((2, 3, 3), 0.5)
    light[0, 0] = [1.5, 2.0, 0.1]
    light[0, 1] = [-0.1, 1.2, 0.0]
    light[1, 1] = 1 + 1e-7
    light[1, 2, 0] = np.nan
    assert count_clipped(light) == (1, 2)
    assert count_clipped(light, exposure=1.1) == (1, 6)
    assert count_clipped(light, exposure=-1.0) == (1, 0)


@pytest.mark.parametrize("exposure", [65.0, float("nan")])
def test_exposure_has_an_interval(exposure):
    with pytest.raises(ValueError, match="-64 to 64 stops"):
        encode_for_display(np.zeros(3), exposure=exposure)


def test_codes_are_not_taken_for_light_nor_light_for_codes():
    with pytest.raises(TypeError, match="uint8"):
        encode_for_display(np.zeros(3, np.uint8))
    with pytest.raises(TypeError, match="float32"):
        decode_from_display(np.zeros(3, np.float32))


# Sharma, Wu and Dalal 2005, table 1, pairs 1, 5, 9, 14, 17, 20, 25 and 34.
SHARMA = np.array([
    [50.0000, 2.6772, -79.7751, 50.0000, 0.0000, -82.7485, 2.0425],
    [50.0000, -1.1848, -84.8006, 50.0000, 0.0000, -82.7485, 1.0000],
    [50.0000, 2.4900, -0.0010, 50.0000, -2.4900, 0.0009, 7.1792],
    [50.0000, -0.0010, 2.4900, 50.0000, 0.0011, -2.4900, 4.7461],
    [50.0000, 2.5000, 0.0000, 73.0000, 25.0000, -18.0000, 27.1492],
    [50.0000, 2.5000, 0.0000, 58.0000, 24.0000, 15.0000, 19.4535],
    [60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644],
    [2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082],
])  # fmt: skip


def test_published_colour_differences():
    differences = lab_difference(SHARMA[:, 0:3], SHARMA[:, 3:6])
    np.testing.assert_allclose(differences, SHARMA[:, 6], atol=5e-5)


def test_lab_of_white_grey_and_red():
    # Grey: 116 (0.18)^(1/3) - 16. Red of Rec.709 under D65: (53.24, 80.09, 67.20), as tabulated widely.
    values = lab(np.array([[1.0, 1, 1], [0.18, 0.18, 0.18], [1.0, 0, 0]]))
    np.testing.assert_allclose(values[0], [100, 0, 0], atol=1e-9)
    np.testing.assert_allclose(values[1], [116 * 0.18 ** (1 / 3) - 16, 0, 0], atol=1e-9)
    np.testing.assert_allclose(values[2], [53.24, 80.09, 67.20], atol=0.02)


def test_colour_difference_of_images():
    black, white = np.zeros((2, 3, 3)), np.ones((2, 3, 3), np.float32)
    np.testing.assert_allclose(ciede2000(black, white), np.full((2, 3), 100.0), atol=1e-9)
    np.testing.assert_array_equal(ciede2000(white, white), np.zeros((2, 3)))


def test_colour_difference_sees_what_a_screen_shows():
    bright, brighter = np.full((1, 1, 3), 3.0), np.full((1, 1, 3), 6.0)
    assert ciede2000(bright, brighter) == 0
    assert ciede2000(bright, brighter, exposure=-3.0) > 10
    brighter[0, 0, 1] = np.nan
    assert np.isnan(ciede2000(bright, brighter))


def test_colour_difference_needs_images_of_one_shape():
    with pytest.raises(ValueError, match=r"\(2, 2, 3\) and \(1, 2, 3\)"):
        ciede2000(np.zeros((2, 2, 3)), np.zeros((1, 2, 3)))


def test_colour_science_is_imported_only_when_called_and_without_warnings():
    program = (
        "import sys, numpy, diffwhitted.image as image\n"
        "assert 'colour' not in sys.modules\n"
        "image.encode_for_display(numpy.zeros(3))\n"
        "assert 'colour' in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
