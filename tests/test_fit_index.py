"""The fit of a refractive index, on its own and with other coefficients, on targets that the fit's renderer did not
make.

Targets are means of points, which is what a camera sees, and POV-Ray's picture of points.
"""

import functools

import equinox as eqx
import numpy as np
import pytest
from test_povray_targets import TARGETS, translated

import diffwhitted as dw
import fitting
from diffwhitted.image import read_image
from fitting.judging._identifiability import QUANTILE
from references.supersampled import INDEX, area_true, changed, spheres


@functools.cache
def small_spheres():
    scene = spheres()
    camera = scene.cameras["main"].resized(80, 60)
    return eqx.tree_at(lambda s: s.cameras, scene, {"main": camera}), camera


@functools.cache
def target(index):
    scene, camera = small_spheres()
    return area_true(changed(scene, index, 0.0), camera, 24).astype(np.float32)


@pytest.mark.parametrize("truth, start", [(1.33, 1.05), (1.33, 2.4), (1.5, 1.1), (1.5, 2.1), (2.2, 1.05), (2.2, 1.5)])
def test_the_index_is_found_from_far_away(truth, start):
    """`benchmarks/edges.py` tries each truth from all of these starts."""
    scene, _ = small_spheres()
    result = fitting.fit(scene, target(truth), [INDEX], start={INDEX: start})
    assert result.status == "converged" and result[INDEX].value == pytest.approx(truth, abs=1e-3)


@pytest.mark.parametrize("start", [2.4])
def test_the_index_is_found_from_povrays_picture_of_points(start):
    scene, _ = translated("glass_ior_1.33", "float32")
    name = next(name for name, material in scene.materials.items() if material.k_t.max() > 0) + ".refractive_index"
    result = fitting.fit(scene, read_image(TARGETS / "glass_ior_1.33.exr").pixels, [name], start={name: start})
    assert result[name].value == pytest.approx(1.33, abs=2e-3)


def test_intervals_cover_the_truth_of_24_noisy_targets():
    """24 targets that the renderer did not make, three standard deviations of the binomial distribution around 95 %.

    `benchmarks/edges.py` measures 200 of them.
    """
    scene, _ = small_spheres()
    scene = changed(scene, 1.5, 0.0)
    clean, random = target(1.5), np.random.default_rng(5)
    results = [
        fitting.fit(scene, clean + random.normal(0, 0.02, clean.shape).astype(np.float32), [INDEX])[INDEX]
        for _ in range(24)
    ]
    covered = np.mean([low <= 1.5 <= high for low, high in (r.interval_95 for r in results)])
    assert covered >= 0.81
    spread = np.std([r.value for r in results])
    of_noise = [np.sqrt(r.standard_error**2 - (r.shift / QUANTILE) ** 2) for r in results]
    assert np.mean(of_noise) == pytest.approx(spread, rel=0.45)


def test_the_index_of_a_slab_before_a_uniform_wall_is_not_identifiable():
    scene = dw.Scene(
        objects=[
            dw.Plane("wall", (0, 0, 1), -3, "wall"),
            dw.Polygon("front", [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], "glass"),
        ],
        materials={"wall": dw.Material(k_a=0.5), "glass": dw.Material(k_t=0.9, refractive_index=1.5)},
        cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 40, 16, 12)},
    )
    picture = np.asarray(dw.render(scene, scene.cameras["main"]))
    result = fitting.fit(scene, picture, [INDEX], start={INDEX: 1.3}, footprint=0)
    assert result.status == "not_identifiable" and result[INDEX].standard_error is None


def test_a_free_index_switches_the_footprint_on():
    scene, camera = small_spheres()
    picture = np.asarray(dw.render(scene, camera))
    on = fitting.fit(scene, picture, [INDEX], max_steps=1)
    assert ("footprint", True) in {(name, there) for name, there, _ in on.effects}
