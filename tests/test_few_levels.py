"""Displays of few levels: the numbers of Hearn and Baker, means, and a loop over pixels as the book has it."""

import struct

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from command_line_samples import SCENE

import diffwhitted as dw
from diffwhitted import InputError, display
from diffwhitted.image import ImageError, read_image
from diffwhitted.image._diffusion import CLASSES, FLOYD_STEINBERG
from fitting.command_line import main

RAMP = np.linspace(0, 1, 21 * 30).reshape(21, 30)
NOISE = np.random.default_rng(0).random((21, 30))


def test_the_matrices_of_the_book():
    """(14-31), (14-32), (14-34) and (14-35)."""
    np.testing.assert_array_equal(display.dither_matrix(2), [[3, 1], [0, 2]])
    np.testing.assert_array_equal(display.dither_matrix(3), [[7, 2, 6], [4, 0, 1], [3, 8, 5]])
    four = [[15, 7, 13, 5], [3, 11, 1, 9], [12, 4, 14, 6], [0, 8, 2, 10]]
    np.testing.assert_array_equal(display.dither_matrix(4), four)
    for size in (6, 8, 12, 16):
        assert sorted(display.dither_matrix(size).ravel()) == list(range(size**2))
    np.testing.assert_array_equal(display.dither_matrix(8)[:4, 4:], 4 * np.asarray(four) + 1)


def test_the_patterns_of_the_book():
    """(14-30) and figures 14-36, 14-37 and 14-40."""
    levels = np.asarray([[0.0, 0.19, 0.2, 0.39, 0.59, 0.79, 0.8, 1.0]])
    on = np.asarray(display.halftone(levels, 2)).reshape(2, 8, 2).sum(axis=(0, 2))
    np.testing.assert_array_equal(on, [0, 0, 1, 1, 2, 3, 4, 4])
    third = np.asarray(display.halftone(np.asarray([[0.35]]), 3))
    np.testing.assert_array_equal(third, [[0, 1, 0], [0, 1, 1], [0, 0, 0]])
    # Thirteen levels by 2 x 2 pixels of four levels; 125 colours by three channels of five.
    sums = np.asarray(display.halftone(np.arange(13)[None] / 12.999, 2, levels=4)).reshape(2, 13, 2).sum(axis=(0, 2))
    np.testing.assert_allclose(sums * 3, np.arange(13), atol=1e-6)
    colours = np.stack(np.meshgrid(*[np.arange(5) / 4.999] * 3), axis=-1).reshape(1, -1, 3)
    dots = np.asarray(display.halftone(colours, 2))
    assert dots.shape == (2, 250, 3)
    assert len(np.unique(dots.reshape(2, 125, 2, 3).sum(axis=(0, 2)), axis=0)) == 125
    # A mask of one's own, and patterns that do not add.
    np.testing.assert_array_equal(display.halftone(np.asarray([[0.2]]), np.asarray([[1, 2], [3, 4]])), [[1, 0], [0, 0]])
    patterns = np.asarray([[[0, 0], [0, 0]], [[1, 0], [0, 1]], [[0, 1], [1, 0.5]]])
    np.testing.assert_array_equal(display.halftone(np.asarray([[0.5, 0.9]]), patterns), [[1, 0, 0, 1], [0, 1, 1, 0.5]])


@pytest.mark.parametrize("size", [2, 3, 4])
def test_ordered_dither_keeps_the_mean_and_is_the_halftone(size):
    """(14-33): a plain area has its own mean to 1 / n^2, and exactly where I is a number of n^2-ths; then it is the
    pattern of that number.
    """
    for number in range(size**2 + 1):
        plain = np.full((2 * size, 3 * size), number / size**2)
        shown = np.asarray(display.ordered_dither(plain, size))
        assert shown.mean() == pytest.approx(number / size**2, abs=1e-12)
        pattern = np.asarray(display.halftone(np.asarray([[(number + 0.5) / (size**2 + 1)]]), size))
        np.testing.assert_array_equal(shown[:size, :size], pattern)
    shown = np.asarray(display.ordered_dither(np.full((2 * size, 3 * size), 0.3), size))
    assert abs(shown.mean() - 0.3) < 1 / size**2
    # By hand: row 0, column 1 of D_2 is 1, so that a light is on there above a quarter.
    if size == 2:
        assert [float(display.ordered_dither(np.full((2, 2), v), 2)[0, 1]) for v in (0.24, 0.26)] == [0, 1]


def test_whitteds_display():
    """Three bits a primary and D_4: 111 intensities between black and white (Whitted 1980, section on results)."""
    asked = np.arange(10001) / 10000
    means = {round(float(m), 9) for m in _plain_means(asked[:, None, None] * np.ones((1, 4, 4)))}
    assert len(means) == 7 * 16 + 1 and len(means - {0.0, 1.0}) == 111


def _plain_means(areas):
    return np.asarray(jax.vmap(lambda area: display.ordered_dither(area, 4, 8).mean())(jnp.asarray(areas)))


def by_hand(image, levels, weights, serpentine=False, rescaled=False):
    """The loop of the book."""
    m, shown = image.copy(), np.zeros_like(image)
    height, width = image.shape
    for i in range(height):
        step = -1 if serpentine and i % 2 else 1
        for j in range(width)[::step]:
            m[i, j] = 0.8 * m[i, j] + 0.1 if rescaled else m[i, j]
            level = np.clip(np.floor(m[i, j] * (levels - 1) + 0.5), 0, levels - 1) / (levels - 1)
            shown[i, j], error = level, m[i, j] - level
            places = (i, j + step), (i + 1, j - step), (i + 1, j), (i + 1, j + step)
            for (row, column), weight in zip(places, weights, strict=True):
                if row < height and 0 <= column < width:
                    m[row, column] += weight * error
    return shown


@pytest.mark.parametrize("serpentine", [False, True])
@pytest.mark.parametrize(("levels", "weights"), [(2, FLOYD_STEINBERG), (4, (0.1, 0.2, 0.3, 0.2))])
def test_error_diffusion_is_the_loop_of_the_book(serpentine, levels, weights):
    shown = display.error_diffusion(NOISE, levels, weights, serpentine)
    np.testing.assert_array_equal(shown, by_hand(NOISE, levels, weights, serpentine))


def test_error_diffusion_keeps_the_mean_and_takes_colours():
    image = np.stack([NOISE, RAMP, 1 - RAMP], axis=-1)
    shown = jax.jit(display.error_diffusion)(image)
    assert shown.shape == image.shape and {*np.unique(shown)} == {0, 1}
    np.testing.assert_array_equal(shown[..., 1], display.error_diffusion(RAMP))
    # What is lost goes past the sides: half an error a pixel of them.
    assert abs(np.asarray(shown - image).sum(axis=(0, 1))).max() < 0.5 * (2 * 21 + 30)
    faded = display.error_diffusion(NOISE, rescaled=True)
    np.testing.assert_array_equal(faded, by_hand(NOISE, 2, FLOYD_STEINBERG, rescaled=True))


def test_dot_diffusion_by_classes():
    """Against a loop over the classes, in their order."""
    assert sorted(CLASSES.ravel()) == list(range(64))
    values, shown = NOISE.copy(), np.zeros_like(NOISE)
    classes = CLASSES[np.arange(21)[:, None] % 8, np.arange(30) % 8]
    for number in range(64):
        for i, j in np.argwhere(classes == number):
            shown[i, j] = values[i, j] >= 0.5
            near = [(i + a, j + b, 2 - abs(a * b)) for a in (-1, 0, 1) for b in (-1, 0, 1)]
            near = [(a, b, w) for a, b, w in near if 0 <= a < 21 and 0 <= b < 30 and classes[a, b] > number]
            for a, b, weight in near:
                values[a, b] += (values[i, j] - shown[i, j]) * weight / sum(w for *_, w in near)
    np.testing.assert_array_equal(display.dot_diffusion(NOISE), shown)
    assert abs(np.asarray(display.dot_diffusion(np.full((64, 64), 0.3), 4)).mean() - 0.3) < 0.01


def test_random_dither_keeps_the_mean():
    shown = np.asarray(display.random_dither(np.full((200, 200, 3), 0.3), jax.random.key(1), 3))
    assert {*np.unique(shown)} <= {0, 0.5, 1} and abs(shown.mean() - 0.3) < 5 * 0.25 / np.sqrt(shown.size)


def test_fit_range():
    np.testing.assert_array_equal(display.fit_range(np.asarray([-1.0, 0.5, 4])), [0, 0.5, 1])
    np.testing.assert_array_equal(display.fit_range(np.asarray([-1.0, 0.5, 4]), "scale"), [0, 0.125, 1])
    np.testing.assert_array_equal(display.fit_range(np.zeros(3), "scale"), np.zeros(3))


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: display.ordered_dither(np.full((2, 2), 1.5)), "the first in row 0, column 0: 1.5; try fit_range"),
        (lambda: display.ordered_dither(np.full((2, 2), np.nan)), "not a number"),
        (lambda: display.ordered_dither(np.zeros((2, 2)), 5), "size = 5"),
        (lambda: display.ordered_dither(np.zeros((2, 2)), 4, 1), "levels = 1; allowed is a whole number from 2"),
        (lambda: display.ordered_dither(np.zeros((2, 2, 4))), "a picture of shape (2, 2, 4)"),
        (lambda: display.ordered_dither(np.zeros((2, 2), int)), "allowed are floats"),
        (lambda: display.halftone(np.zeros((2, 2)), np.asarray([[1, 1], [2, 3]])), "each once"),
        (lambda: display.halftone(np.zeros((2, 2)), np.zeros((3, 2, 1))), "patterns of shape (3, 2, 1)"),
        (lambda: display.error_diffusion(np.zeros((2, 2)), weights=(1, 1, 0, 0)), "sum of at most 1"),
        (lambda: display.fit_range(np.zeros(2), "largest"), 'allowed is "clamp" or "scale"'),
    ],
)
def test_what_is_refused(call, said):
    with pytest.raises(InputError) as error:
        call()
    assert said in str(error.value)


def test_a_palette_has_as_few_bits_as_it_needs(tmp_path):
    """1 bit for black and white, 2 for four greys, 4 for the eight colours of three channels; and comes back."""
    for shape, levels, bits in (((21, 30), 2, 1), ((21, 30), 4, 2), ((21, 30, 3), 2, 4)):
        image = np.random.default_rng(levels).random(shape)
        shown = np.asarray(display.ordered_dither(image, 4, levels))
        display.write_palette(tmp_path / "a.png", shown, levels, metadata={"levels": levels})
        data = (tmp_path / "a.png").read_bytes()
        assert (data[24], data[25]) == (bits, 3) and struct.unpack(">II", data[16:24]) == (30, 21) and b"sRGB" in data
        back = read_image(tmp_path / "a.png").pixels
        np.testing.assert_allclose(back, shown if shown.ndim == 3 else shown[..., None] * np.ones(3), atol=4e-3)
    with pytest.raises(ImageError, match="on none of 2 levels"):
        display.write_palette(tmp_path / "a.png", np.full((2, 2), 0.3), 2)
    with pytest.raises(ImageError, match="a palette is for .png"):
        display.write_palette(tmp_path / "a.exr", np.zeros((2, 2)), 2)


def test_render_on_few_levels(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(SCENE)
    out = tmp_path / "a.png"

    def render(*words, to=out):
        return main(["render", str(tmp_path / "scene.toml"), "-o", str(to), *words])

    assert render("--display", "halftone:2") == 0
    assert (read_image(out).pixels.shape, out.read_bytes()[25]) == ((24, 32, 3), 3)
    assert render("--display", "error-diffusion", "--levels", "4", to=tmp_path / "a.exr") == 0
    found = np.unique(read_image(tmp_path / "a.exr").pixels)
    assert np.abs(found[:, None] - np.arange(4) / 3).min(axis=1).max() < 1e-6 and len(found) > 2
    capsys.readouterr()
    for words, said in (
        (("--display", "ordred"), "allowed is ordered or ordered:N"),
        (("--display", "ordered:5"), "size = 5"),
        (("--display", "ordered", "--levels", "1"), "--levels 1: allowed is 2 to 256"),
    ):
        assert render(*words) == 2 and said in capsys.readouterr().err
    assert render("--display", "ordered", to=tmp_path / "a.jpg") == 2 and "blur the dots" in capsys.readouterr().err
    assert dw.display is display
