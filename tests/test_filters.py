"""Reconstruction filters: their formulas, and targets that were averaged under them."""

import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.image._filters import filter_matrix, filter_weight, filtered

TRUE = {"paint.k_a": 0.1, "paint.k_d": 0.5, "paint.k_h": 0.4, "floor.k_d": 0.6}
WIDTH, HEIGHT, FINE = 24, 18, 12


def scene(k_a=0.1, k_d=0.5, k_h=0.4, floor=0.6):
    """A ball over the edge of a floor, which is at the edge of the picture too."""
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint"), dw.Plane("ground", (0, 1, 0), -1, "floor")],
        materials={
            "paint": dw.Material(k_a=k_a, k_d=k_d, k_h=k_h, phong_exponent=20),
            "floor": dw.Material(k_a=0.05, k_d=floor),
        },
        lights=[dw.PointLight((-3, 5, 4), 0.8)],
        ambient=(0.3, 0.3, 0.3),
        background=dw.ConstantBackground((0.1, 0.2, 0.4)),
        cameras={"main": dw.Camera((0, 0.5, 4), (0, 0, 0), 50, WIDTH, HEIGHT)},
    )


def gaussian(x):
    """Of standard deviation 1/2, cut off at 4 of them and lowered to end there at 0."""
    return np.where(abs(x) < 2, np.exp(-2 * x * x) - np.exp(-8.0), 0)


def mitchell(x):
    """Mitchell and Netravali 1988, their equation for B = C = 1/3: (7 x^3 - 12 x^2 + 16/3) / 6 and (-7/3 x^3 + 12 x^2 -
    20 x + 32/3) / 6.
    """
    x = abs(x)
    far = (-7 / 3 * x**3 + 12 * x**2 - 20 * x + 32 / 3) / 6
    return np.where(x < 1, (7 * x**3 - 12 * x**2 + 16 / 3) / 6, np.where(x < 2, far, 0))


FORMULAS = {"gaussian": gaussian, "mitchell": mitchell}


def averaged(kind):
    """The true picture by 12 x 12 points a pixel under a filter; points outside the picture are none."""
    world = scene()
    fine = np.asarray(dw.render(world, world.cameras["main"].resized(FINE * WIDTH, FINE * HEIGHT)), np.float64)
    down, across = ((np.arange(FINE * n) + 0.5) / FINE for n in (HEIGHT, WIDTH))
    picture = np.empty((HEIGHT, WIDTH, 3))
    for row in range(HEIGHT):
        for column in range(WIDTH):
            weight = np.outer(FORMULAS[kind](down - row - 0.5), FORMULAS[kind](across - column - 0.5))
            picture[row, column] = np.tensordot(weight, fine, 2) / weight.sum()
    return picture


@pytest.mark.parametrize("kind", FORMULAS)
def test_weights_are_those_of_the_formulas(kind):
    x = np.linspace(-2.5, 2.5, 101)
    np.testing.assert_allclose(filter_weight(kind, x), FORMULAS[kind](x), atol=1e-12)
    assert filter_weight("mitchell", np.array([1.2])) < 0
    # A sample in the middle of pixel 3 counts for pixel 2 as one at the distance of 1.
    assert filter_matrix(kind, 8, 0.5)[2, 3] == pytest.approx(float(FORMULAS[kind](1.0)))


@pytest.mark.parametrize("kind", ["box", *FORMULAS])
def test_an_even_picture_stays_as_it_is(kind):
    np.testing.assert_allclose(filtered(np.full((24, 32, 3), 0.7), 4, kind), np.full((6, 8, 3), 0.7), rtol=1e-12)


@pytest.mark.parametrize("kind", FORMULAS)
def test_a_target_under_a_filter_fits_back(kind):
    """With some noise: within its intervals and a hundredth; what leaves the filter out is further off and leaves more
    over.
    """
    target, free = averaged(kind), list(TRUE)
    target += 0.001 * np.random.default_rng(3).normal(size=target.shape)
    start = scene(0.3, 0.3, 0.2, 0.3)
    found = fitting.fit(start, fitting.Target(target, shot=dw.Shot("main", filter=kind)), free)
    box = fitting.fit(start, fitting.Target(target, shot=dw.Shot("main", filter="box")), free)
    assert found.sampling == box.sampling == "pixel" and found.status == "converged", found.message
    assert found.rmse < 0.6 * box.rmse
    off = off_box = 0.0
    for name, value in TRUE.items():
        coefficient = found[name]
        low, high = coefficient.interval_95
        assert low <= value <= high, (name, coefficient)
        assert coefficient.value == pytest.approx(value, rel=0.01)
        off += (coefficient.value / value - 1) ** 2
        off_box += (box[name].value / value - 1) ** 2
    assert off < off_box / 4


def test_derivatives_go_through_the_filter():
    """The rows of a fit against central differences of what it shows."""
    from fitting.problem._build import build
    from fitting.problem._sought import Wishes, sought
    from fitting.problem._target import as_targets
    from fitting.problem._whole_pictures import whole_rows

    world = scene()
    targets = as_targets(world, fitting.Target(averaged("mitchell"), shot=dw.Shot("main", filter="mitchell")))
    wanted = sought(world, ["paint.k_d", "paint.k_h"], Wishes({}, {}, {}, {}))
    values = np.array([0.5, 0.4])
    problem, _ = build(world, targets, ["paint.k_d", "paint.k_h"], wanted, values, 4, None, 0)
    (rows,) = whole_rows(problem, values)
    for k in range(2):
        step = np.eye(2)[k] * 0.05
        above, below = (next(whole_rows(problem, values + sign * step)).shown for sign in (1, -1))
        slope = rows.columns[:, :, rows.numbers.index(k)] / rows.view.weight
        np.testing.assert_allclose(slope, (above - below) / 0.1, atol=2e-5)
