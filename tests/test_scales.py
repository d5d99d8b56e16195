"""Vectors of any length that a user may write have the direction that they have."""

import numpy as np
import pytest

import diffwhitted as dw

SIZES = [1e-30, 1e-25, 1e20, 1e30]


def seen(*, normal=(0, 1, 0), direction=(1, 2, 2), up=(0, 1, 0)) -> np.ndarray:
    """A floor at height -1 and a ball, from a little above."""
    scene = dw.Scene(
        objects=[dw.Plane("floor", normal, -normal[1], "m"), dw.Sphere("ball", (0, 0, 0), 0.5, "m")],
        materials={"m": dw.Material(k_a=0.1, k_d=0.5, k_s=0.2)},
        lights=[dw.DirectionalLight(direction, 1)],
        background=dw.GradientBackground((0.1, 0.2, 0.9), (0.9, 0.9, 0.9)),
    )
    return np.asarray(dw.render(scene, dw.Camera((0, 1, 5), (0, 0, 0), 40, 24, 18, up=up)))


@pytest.fixture(scope="module")
def usual() -> np.ndarray:
    return seen()


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("field", ["normal", "direction", "up"])
def test_the_length_of_a_vector_does_not_matter(usual, field, size):
    unit = {"normal": (0, 1, 0), "direction": (1, 2, 2), "up": (0, 1, 0)}[field]
    np.testing.assert_allclose(seen(**{field: tuple(size * c for c in unit)}), usual, atol=1e-5)


def test_a_refractive_index_has_an_end():
    assert float(dw.Material(k_t=1.0, refractive_index=1000.0).refractive_index) == 1000
    with pytest.raises(dw.SceneError, match=r"refractive_index = 1001; allowed is >= 1 and <= 1000"):
        dw.Material(k_t=1.0, refractive_index=1001.0)
