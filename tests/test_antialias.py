"""Antialiasing by Whitted's scheme: what is divided, what is found, and how it compares with samples everywhere."""

import functools

import numpy as np
import pytest

import diffwhitted as dw

WHITE = dw.Material(k_a=1.0, k_h=0.0)


def scene_of(*objects):
    return dw.Scene(
        objects=objects, materials={"white": WHITE}, cameras={"main": dw.Camera((0, 0, 0), (0, 0, -1), 40, 32, 24)}
    )


@functools.cache
def disc():
    """One bright ball: flat inside and outside, an edge between."""
    scene = scene_of(dw.Sphere("ball", (0.1, 0.05, -10), 2.0, "white"))
    return scene, scene.cameras["main"], dw.antialias(scene, scene.cameras["main"], 0.1)


def test_pixels_are_divided_where_the_edge_is_and_nowhere_else():
    _, _, found = disc()
    assert found.squares.min() == 1 and 16 < found.squares.max() <= 64
    flat = (found.image == 0) | (found.image == 1)
    assert (found.squares[flat.all(axis=-1)] == 1).mean() > 0.95
    assert 0.05 < (found.squares > 1).mean() < 0.25


def test_it_is_as_true_as_samples_everywhere_with_fewer_of_them():
    """Against 32 x 32 points a pixel: an edge seen by 8 x 8 squares is in error by less than that seen by 4 x 4
    points.
    """
    scene, camera, found = disc()
    truth, points = (np.asarray(dw.render(scene, camera, samples=n), np.float64) for n in (32, 4))
    assert np.sqrt(((found.image - truth) ** 2).mean()) < 0.7 * np.sqrt(((points - truth) ** 2).mean())
    assert found.samples < 0.5 * 16 * 32 * 24 and found.samples >= 33 * 25


def test_weights_are_areas():
    """The light of the whole picture is that of the ball's area."""
    scene, camera, found = disc()
    assert found.image.sum() == pytest.approx(float(dw.render(scene, camera, samples=32).sum()), rel=2e-3)


def test_corners_are_shared():
    """A picture of one colour takes one more row and column of samples than it has pixels, and a coarser threshold no
    more samples.
    """
    scene, camera, found = disc()
    inside = dw.antialias(scene_of(dw.Sphere("ball", (0, 0, -10), 200.0, "white")), camera, 0.1)
    assert inside.samples == 33 * 25 == inside.rays and (inside.image == 1).all()
    assert dw.antialias(scene, camera, 0.9, levels=1).samples < found.samples


def test_a_thin_far_cylinder_of_small_spheres_is_found():
    """A string of beads, a fifth of a pixel thick: points in the middles of the pixels miss it, and so do corners."""
    pixel = 2 * np.tan(np.radians(20)) / 24 * 50
    beads = [dw.Sphere(f"bead {k}", (0.27 * pixel, 0.1 * k * pixel, -50), 0.1 * pixel, "white") for k in range(-20, 21)]
    scene = scene_of(*beads)
    camera = scene.cameras["main"]
    assert np.asarray(dw.render(scene, camera)).sum() == 0
    assert dw.antialias(scene, camera, 0.1).image.sum() > 0
    found = dw.antialias(scene, camera, 0.1, levels=5)
    truth = np.asarray(dw.render(scene, camera, samples=32), np.float64)
    assert found.image.sum() == pytest.approx(truth.sum(), rel=0.1) and (found.image.sum(axis=(0, 2)) > 0).sum() == 1


def test_render_hands_over_to_it():
    scene, camera, found = disc()
    np.testing.assert_array_equal(dw.render(scene, camera, antialias=0.1), found.image)


@pytest.mark.parametrize(
    "options, words",
    [
        ({"antialias": 0}, "antialias = 0"),
        ({"antialias": -1.0}, "antialias = -1"),
        ({"antialias": float("nan")}, "antialias = nan"),
        ({"antialias": "much"}, "antialias = 'much'"),
        ({"antialias": 0.1, "samples": 2}, "samples = 2"),
        ({"antialias": 0.1, "footprint": 1}, "footprint = 1"),
    ],
)
def test_options_that_are_none_are_refused(options, words):
    scene, camera, _ = disc()
    with pytest.raises(dw.SceneError, match=words):
        dw.render(scene, camera, **options)


def test_a_number_of_levels_that_is_none_is_refused():
    scene, camera, _ = disc()
    with pytest.raises(dw.SceneError, match="levels = 9"):
        dw.antialias(scene, camera, 0.1, levels=9)
