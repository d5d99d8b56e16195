"""Coefficients that a bound holds: where the others come to rest, and what is said of all of them."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize_scalar

import fitting
from diffwhitted import Camera, Material, PointLight, Scene, Sphere, render

FREE = ["m.k_[adh]", "m.phong_exponent"]


def ball(**coefficients) -> Scene:
    material = {"k_a": 0.1, "k_d": [0.6, 0.2, 0.1], "k_h": 0.3, "phong_exponent": 40.0} | coefficients
    return Scene(
        objects=[Sphere("s", (0, 0, 0), 1, "m")],
        materials={"m": Material(**material)},
        lights=[PointLight((3, 5, 4), 1)],
        cameras={"main": Camera((0, 1.2, 5), (0, 0, 0), 30, 24, 18)},
    )


def picture(**coefficients) -> np.ndarray:
    scene = ball(**coefficients)
    return np.asarray(render(scene, scene.cameras["main"]), np.float64)


@pytest.fixture(scope="module")
def bounded():
    """The red channel may not be what it is; the rest comes to rest beside it."""
    start = ball(k_d=[0.3] * 3, k_h=0.1, phong_exponent=10.0)
    return fitting.fit(start, picture(), FREE, bounds={"m.k_d": (0, 0.4)}, footprint=0, samples=1)


def expected() -> tuple[float, np.ndarray, np.ndarray]:
    """The exponent and the linear coefficients (a, r, g, b, h) by scipy's bounded linear least squares, and its
    Jacobian."""
    target = picture()
    nothing = np.zeros((18, 24, 3))
    ambient = picture(k_a=1.0, k_d=[0.0] * 3, k_h=0.0) - nothing
    diffuse = picture(k_a=0.0, k_d=[1.0] * 3, k_h=0.0) - nothing

    def columns(n: float) -> np.ndarray:
        shine = picture(k_a=0.0, k_d=[0.0] * 3, k_h=1.0, phong_exponent=n) - nothing
        return np.stack([p.ravel() for p in (ambient, *(diffuse * c for c in np.eye(3)), shine)], axis=1)

    def best(n: float):
        return lsq_linear(columns(n), (target - nothing).ravel(), ([0] * 5, [1, 0.4, 0.4, 0.4, 1]), tol=1e-12)

    n = minimize_scalar(lambda n: best(n).cost, bounds=(2, 40), method="bounded", options={"xatol": 1e-4}).x
    return n, best(n).x, columns(n)


def test_the_answer_beside_a_bound_is_that_of_bounded_least_squares(bounded):
    n, linear, _ = expected()
    found = [bounded[name].value for name in ("m.k_a", "m.k_d.r", "m.k_d.g", "m.k_d.b", "m.k_h")]
    np.testing.assert_allclose(found, linear, atol=2e-3)
    assert bounded["m.phong_exponent"].value == pytest.approx(n, rel=0.02)


def test_a_fit_held_at_a_bound_has_converged(bounded):
    assert (bounded.status, bounded.exit_code) == ("converged", 0), bounded.message
    assert bounded["m.k_d.r"].at_bound and bounded["m.k_d.r"].value == 0.4
    low, high = bounded["m.k_d.r"].interval_95
    assert low < 0.4 and high == 0.4
    assert all(c.standard_error is not None for c in bounded.coefficients)


@pytest.mark.parametrize("seed", range(3))
def test_the_interval_of_what_lies_on_a_bound_is_one_sided(seed):
    """A single linear coefficient with a known noise: its standard error is noise / |column|."""
    noise = np.random.default_rng(seed).normal(size=(18, 24, 3))
    noise -= noise.mean() + 3 / np.sqrt(noise.size)  # so that it lies on its bound, whatever the seed
    target = fitting.Target(picture(k_d=0.0, k_h=0.0) + 0.01 * noise, noise=0.01)
    result = fitting.fit(ball(k_d=0.2, k_h=0.0), target, ["m.k_d"])
    found = result["m.k_d"]
    column = picture(k_a=0.0, k_d=1.0, k_h=0.0)
    error = 0.01 / np.linalg.norm(column)
    assert result.status == "converged" and found.at_bound
    assert found.standard_error == pytest.approx(error, rel=1e-3)
    assert found.interval_95 == pytest.approx((0, found.value + 1.645 * error), rel=1e-3)


def test_what_a_bound_holds_adds_nothing_to_the_errors_of_the_others():
    """k_h is held at 0 by far; k_a and k_d have the errors of the problem without it."""
    noise = 0.01 * np.random.default_rng(1).normal(size=(18, 24, 3))
    shine = picture(k_a=0.0, k_d=0.0, k_h=0.1, phong_exponent=10.0)
    target = fitting.Target(picture(k_d=0.4, k_h=0.0) - shine + noise, noise=0.01)
    start = ball(k_d=0.2, k_h=0.1, phong_exponent=10.0)
    held = fitting.fit(start, target, ["m.k_a", "m.k_d", "m.k_h"])
    alone = fitting.fit(ball(k_d=0.2, k_h=0.0, phong_exponent=10.0), target, ["m.k_a", "m.k_d"])
    assert held["m.k_h"].at_bound and held.status == "converged"
    for name in ("m.k_a", "m.k_d"):
        assert held[name].value == pytest.approx(alone[name].value, abs=1e-5)


def test_bounds_that_leave_nothing_say_what_to_do():
    with pytest.raises(fitting.FitError, match=r"m.k_h = 0.3 to 0.3 .* leave it out of free .* write 0.3 in the scene"):
        fitting.fit(ball(), picture(), FREE, bounds={"m.k_h": (0.3, 0.3)})


@pytest.mark.parametrize("option", ["start", "bounds"])
def test_a_name_that_is_not_free_is_answered_with_the_nearest(option):
    given = {option: {"m.kd": 0.3 if option == "start" else (0, 1)}}
    with pytest.raises(fitting.FitError, match=r"matches no free coefficient.* Did you mean 'm.k_d'"):
        fitting.fit(ball(), picture(), FREE, **given)
