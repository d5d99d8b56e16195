"""Pictures as people have them: averaged over pixels, of whole numbers, and of another model than the scene's."""

import functools
from pathlib import Path

import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.image import encode_signal

FREE = ["paint.k_[adh]", "paint.phong_exponent", "floor.k_[ad]"]
TRUE = {
    "paint.k_a": 0.1,
    "paint.k_d": 0.6,
    "paint.k_h": 0.3,
    "paint.phong_exponent": 40.0,
    "floor.k_a": 0.1,
    "floor.k_d": 0.7,
}


@functools.cache
def studio(start=False, highlight="halfway"):
    """A ball on tiles."""
    k_a, k_d, k_h, n = (0.2, 0.4, 0.1, 15.0) if start else (0.1, 0.6, 0.3, 40.0)
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 0.7, "paint"), dw.Plane("ground", (0, 1, 0), -0.7, "floor")],
        materials={
            "paint": dw.Material(k_a=k_a, k_d=k_d, k_h=k_h, phong_exponent=n, highlight=highlight),
            "floor": dw.Material(
                k_a=k_a, k_d=0.7 - 0.3 * start, k_h=0, k_d_texture="tiles", k_a_texture="tiles", highlight="off"
            ),
        },
        textures={"tiles": dw.Checker([[0.9, 0.2, 0.2], [1, 1, 1]], 0.5, "xz")},
        lights=[dw.PointLight((3, 5, 4), 1.0)],
        background=dw.ConstantBackground([0.1, 0.2, 0.3]),
        cameras={"main": dw.Camera((0, 1.2, 5), (0, 0, 0), 30, 80, 60)},
    )


@functools.cache
def picture(samples=1, highlight="halfway"):
    scene = studio(False, highlight)
    return np.asarray(dw.render(scene, scene.cameras["main"], samples=samples, footprint=0), np.float64)


def found(target, **how):
    return fitting.fit(studio(True), target, FREE, **how)


@pytest.mark.parametrize("samples, sampling", [(1, "points"), (6, "pixel"), (8, "pixel")])
def test_points_and_averages_are_told_apart(samples, sampling):
    """All weights of light within 1 % and inside their intervals, with no option."""
    result = found(picture(samples).astype(np.float32))
    assert (result.sampling, result.status) == (sampling, "converged"), result.message
    assert sampling == result.to_json()["sampling"]
    for name, value in TRUE.items():
        low, high = result[name].interval_95
        assert result[name].value == pytest.approx(value, rel=0.03 if "k_a" in name else 0.01), name
        assert low - 1e-6 <= value <= high + 1e-6, name


def eight_bits(path, light):
    """A file of sRGB codes."""
    dw.write_image(path, light.astype(np.float32))
    return dw.read_image(path)


def test_eight_bits_without_noise_are_certain_bounds(tmp_path):
    """Far closer than a code is wide, and never outside."""
    result = found(eight_bits(tmp_path / "exact.png", picture()))
    assert result.status == "converged" and "certain bounds" in result.message
    for name, value in TRUE.items():
        low, high = result[name].interval_95
        assert low <= value <= high and result[name].value == pytest.approx(value, rel=2e-3), name
    assert result["floor.k_d"].value == pytest.approx(0.7, abs=5e-5)


@pytest.mark.parametrize("noise", [0.0007, 0.004])
def test_eight_bits_with_noise_have_intervals_that_hold(tmp_path, noise):
    """Ten pictures, 60 intervals: 95 % of them hold, and no fewer than four standard deviations below that."""
    random, inside = np.random.default_rng(7), []
    for _ in range(10):
        light = picture() + noise * random.normal(size=picture().shape)
        result = found(eight_bits(tmp_path / "noisy.png", light))
        assert not result.misfit
        for name, value in TRUE.items():
            low, high = result[name].interval_95
            inside.append(low <= value <= high)
    assert np.mean(inside) > 0.95 - 4 * np.sqrt(0.95 * 0.05 / 60)


MISTAKES = {
    "upside down": lambda: picture()[::-1],
    "left to right": lambda: picture()[:, ::-1],
    "shifted by a pixel down": lambda: np.roll(picture(), 1, axis=0),
    "--encoding srgb": lambda: encode_signal(picture(), "srgb"),
}


@pytest.mark.parametrize("said", MISTAKES)
def test_a_likely_mistake_is_named(said):
    result = found(MISTAKES[said]().astype(np.float32))
    assert result.misfit and result.exit_code == 1
    assert any(said in what for what, _ in result.causes[:2]), result.causes
    assert said in result.message


@pytest.mark.slow
def test_a_few_edge_pixels_of_another_program_are_no_misfit():
    """POV-Ray's points: some pixels on edges lie on the other side. That is the rounding of two programs."""
    examples = Path(__file__).parents[1] / "examples"
    scene = dw.load_scene(examples / "three_spheres_truth.toml")
    target = dw.read_image(examples / "three_spheres_povray.exr")
    names = ["glass.k_*", "mirror.k_[adhs]", "green.k_[adhs]", "*.phong_exponent"]
    result = fitting.fit(scene, target, names, start={"glass.k_t": 0.5, "mirror.k_s": 0.4, "green.k_s": 0.3})
    assert result.status == "converged" and result.sampling == "points", result.message
    for name, value in (("glass.k_t", 0.7), ("mirror.k_s", 0.7), ("green.k_s", 0.1)):
        assert result[name].value == pytest.approx(value, rel=1e-3), name
