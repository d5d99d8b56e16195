"""Highlights that no pixel shows: whether there is none, a faint one or a sharp one between the pixels."""

import functools

import numpy as np
import pytest

import diffwhitted as dw
import fitting

SIZE, NOISE = 32, 0.002
FREE = ("paint.k_d", "paint.k_h", "paint.phong_exponent")
HIGHLIGHT = ("paint.k_h", "paint.phong_exponent")


def ball(**material) -> dw.Scene:
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint")],
        materials={"paint": dw.Material(k_a=0.05, highlight="reflected", **material)},
        lights=[dw.PointLight((3, 4, 5), (0.9, 0.9, 0.9), name="key")],
        ambient=1.0,
        cameras={"main": dw.Camera((0, 0, 5), (0, 0, 0), 26, SIZE, SIZE)},
        max_depth=1,
    )


@functools.cache
def fitted(k_h: float, exponent: float, noise: float = NOISE, top: float = 1e6) -> fitting.FitResult:
    scene = ball(k_d=0.4, k_h=k_h, phong_exponent=exponent)
    picture = np.asarray(dw.render(scene, scene.cameras["main"]))
    picture = picture + noise * np.random.default_rng(1).normal(size=picture.shape)
    start = ball(k_d=0.3, k_h=0.2, phong_exponent=30)
    return fitting.fit(start, picture, FREE, bounds={"paint.phong_exponent": (1, top)})


def test_a_highlight_that_is_seen_is_told():
    found = fitted(0.1, 40)
    assert found.status == "converged"
    for name, truth in (("paint.k_d", 0.4), ("paint.k_h", 0.1), ("paint.phong_exponent", 40)):
        coefficient = found[name]
        assert coefficient.interval_95 is not None
        assert abs(coefficient.value - truth) < 4 * coefficient.standard_error


@pytest.mark.parametrize("k_h", [0.0, 0.0005, 0.1])
def test_one_that_no_pixel_shows_is_not_known(k_h):
    """Of the last, half as wide as .2 degrees, no pixel of 6 degrees lies near the middle."""
    found = fitted(k_h, 1e5)
    assert found.status == "not_identifiable"
    assert [c.name for c in found.coefficients if not c.identifiable] == list(HIGHLIGHT)
    assert all(found[name].interval_95 is None for name in HIGHLIGHT)
    assert "no highlight of paint stands out of the noise" in found.message
    low, high = found["paint.k_d"].interval_95
    assert low <= 0.4 <= high


def test_what_the_bounds_do_not_allow_is_not_feared():
    """No highlight of an exponent up to 100 hides between these pixels: k_h is known, the exponent of none is not."""
    found = fitted(0.0, 1e5, top=100)
    assert [c.name for c in found.coefficients if not c.identifiable] == ["paint.phong_exponent"]
    low, high = found["paint.k_h"].interval_95
    assert low == 0 and 0 < high < 0.02


def test_one_pixel_tells_neither_how_much_nor_how_sharp():
    """A sharp highlight right in the middle of a pixel: the same picture with a larger k_h and another exponent."""
    scene, plain = (ball(k_d=0.4, k_h=k_h, phong_exponent=3e4) for k_h in (0.1, 0.0))
    lit, picture = (np.array(dw.render(scene, scene.cameras["main"])) for scene in (scene, plain))
    bright = np.unravel_index((lit - picture)[..., 0].argmax(), picture.shape[:2])
    picture += NOISE * np.random.default_rng(1).normal(size=picture.shape)
    picture[bright] += 0.08
    found = fitting.fit(ball(k_d=0.3, k_h=0.2, phong_exponent=1000), picture, FREE)
    assert all(not found[name].identifiable for name in HIGHLIGHT)
    assert found["paint.k_d"].identifiable
