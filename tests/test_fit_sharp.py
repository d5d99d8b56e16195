"""Sharp highlights: exponents far beyond 1000, and those that no picture tells."""

import numpy as np
import pytest

import fitting
from diffwhitted import Camera, Material, PointLight, Scene, Sphere, render


def ball(k_h: float, exponent: float, width: int = 160, height: int = 120) -> Scene:
    return Scene(
        objects=[Sphere("s", (0, 0, 0), 1, "m")],
        materials={"m": Material(k_d=0.2, k_h=k_h, phong_exponent=exponent)},
        lights=[PointLight((3, 5, 4), 1), PointLight((-4, 2, 5), 1)],
        cameras={"main": Camera((0, 0, 5), (0, 0, 0), 28, width, height)},
    )


def noisy(scene: Scene) -> np.ndarray:
    image = np.asarray(render(scene, scene.cameras["main"]), np.float64)
    return image + 0.002 * np.random.default_rng(0).normal(size=image.shape)


@pytest.mark.parametrize("k_h, exponent", [(0.0287, 2582.0), (0.11, 14531.0)])
def test_sharp_materials_are_found_from_a_dull_start(k_h, exponent):
    """Two measured materials, with the default bounds."""
    result = fitting.fit(ball(0.1, 50.0), noisy(ball(k_h, exponent)), ["m.k_d", "m.k_h", "m.phong_exponent"])
    assert result.status == "converged", result.message
    for name, truth in (("m.k_h", k_h), ("m.phong_exponent", exponent)):
        assert abs(result[name].value - truth) < 3.5 * result[name].standard_error
        assert result[name].value == pytest.approx(truth, rel=0.15)


def test_a_highlight_smaller_than_a_pixel_is_unknowable():
    """Each highlight of n = 3e5 is a tenth of a degree wide, a pixel here five."""
    start, target = ball(0.5, 2e5, 24, 18), ball(0.8, 3e5, 24, 18)
    # One of the pixels looks where the light is mirrored.
    result = fitting.fit(start, noisy(target), ["m.k_d", "m.phong_exponent"])
    assert result.status == "not_identifiable", result.message
    assert not result["m.phong_exponent"].identifiable and result["m.k_d"].identifiable


def test_what_goes_along_with_a_number_on_its_bound_says_so():
    """The exponent is bound to 1000; k_h of the highlight goes along with it."""
    target, names = noisy(ball(0.2, 3000.0)), ["m.k_d", "m.k_h", "m.phong_exponent"]
    result = fitting.fit(ball(0.1, 50.0), target, names, bounds={"m.phong_exponent": (1, 1000)})
    assert result["m.phong_exponent"].at_bound
    i, j = 1, 2
    remark = "goes along with m.phong_exponent, which is at its upper bound 1000"
    assert (abs(result.correlation[i, j]) > 0.9) == (remark in result["m.k_h"].remark)
