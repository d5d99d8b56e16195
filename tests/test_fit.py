"""Fits: known coefficients are found from far away, and what cannot be known is said to be so."""

from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted
import fitting
from diffwhitted import Camera, Material, Plane, PointLight, Scene, Sphere, replace_coefficient
from diffwhitted.image import dealt
from fitting._outcome import outcome
from fitting.problem._build import build
from fitting.problem._target import as_targets
from fitting.problem._ties import tied
from fitting.problem._unknowns import list_unknowns
from fitting.solving._settling import Settled
from fitting.solving._solve import solve


def studio(**glass) -> Scene:
    """A translucent sphere and a mirror over a grey floor; two cameras."""
    coefficients = {"k_a": 0.05, "k_d": 0.3, "k_h": 0.4, "k_s": 0.2, "k_t": 0.5, "phong_exponent": 20.0} | glass
    return Scene(
        objects=[
            Sphere("ball", (0, 0, 0), 1, "glass"),
            Sphere("globe", (1.5, 0.2, -1.5), 0.8, "chrome"),
            Plane("ground", (0, 1, 0), -1.2, "floor"),
        ],
        materials={
            "glass": Material(refractive_index=1.0, **coefficients),
            "chrome": Material(k_d=0.2, k_s=0.7),
            "floor": Material(k_a=0.1, k_d=(0.7, 0.6, 0.5)),
            "spare": Material(k_d=0.5),
        },
        lights=[PointLight((3, 5, 4), (0.9, 0.9, 0.9)), PointLight((-4, 4, 2), (0.4, 0.4, 0.5))],
        cameras={"main": Camera((0, 0.5, 5), (0, 0, 0), 40, 40, 30), "side": Camera((4, 1, 3), (0, 0, 0), 40, 32, 24)},
        background=diffwhitted.ConstantBackground((0.3, 0.5, 0.8)),
    )


def picture(scene: Scene, camera: str = "main") -> np.ndarray:
    return np.asarray(diffwhitted.render(scene, scene.cameras[camera]))


FREE = ("glass.k_*", "glass.phong_exponent", "chrome.k_s", "floor.k_d")
TRUTH = {
    "glass.k_a": 0.05,
    "glass.k_d": 0.3,
    "glass.k_h": 0.4,
    "glass.k_s": 0.2,
    "glass.k_t": 0.5,
    "glass.phong_exponent": 20.0,
    "chrome.k_s": 0.7,
    "floor.k_d.r": 0.7,
    "floor.k_d.g": 0.6,
    "floor.k_d.b": 0.5,
}


@pytest.fixture(scope="module")
def far_fit():
    """From the middle of the bounds: ten unknowns."""
    start = {"*.k_*": 0.5, "*.phong_exponent": 1000**0.5}
    return fitting.fit(studio(), picture(studio()), FREE, start=start)


def test_coefficients_are_recovered_from_the_middle_of_the_bounds(far_fit):
    assert far_fit.status == "converged", far_fit.message
    assert {c.name for c in far_fit.coefficients} == set(TRUTH)
    for name, value in TRUTH.items():
        assert far_fit[name].value == pytest.approx(value, rel=1e-5, abs=1e-5), name
        assert far_fit[name].identifiable


def test_the_fitted_scene_holds_the_fitted_values_and_renders_the_target(far_fit):
    np.testing.assert_allclose(picture(far_fit.scene), picture(studio()), atol=2e-5)
    assert far_fit.rmse < 1e-5
    np.testing.assert_allclose(far_fit.views[0].render, far_fit.views[0].target, atol=1e-4)


def test_history_falls_to_the_end(far_fit):
    losses = [step.loss for step in far_fit.history if step.accepted]
    assert losses == sorted(losses, reverse=True)
    assert far_fit.steps == len(far_fit.history) <= 60


def test_two_cameras_and_a_mask_leave_out_what_is_wrong():
    scene = studio()
    main, side = picture(scene).copy(), picture(scene, "side")
    main[:, :10] = np.nan
    mask = np.ones(main.shape[:2])
    mask[:, :10] = 0
    result = fitting.fit(
        studio(k_d=0.5, k_s=0.5),
        [fitting.Target(main, "main", mask), fitting.Target(side, "side")],
        ["glass.k_d", "glass.k_s"],
    )
    assert result["glass.k_d"].value == pytest.approx(0.3, abs=1e-5)
    assert result["glass.k_s"].value == pytest.approx(0.2, abs=1e-5)
    assert np.all(result.views[0].residual[:, :10] == 0)
    assert [view.camera for view in result.views] == ["main", "side"]


def test_a_coefficient_that_is_zero_in_the_scene_is_found():
    result = fitting.fit(studio(k_s=0.0, k_t=0.0), picture(studio()), ["glass.k_s", "glass.k_t"])
    assert result["glass.k_s"].value == pytest.approx(0.2, abs=1e-5)
    assert result["glass.k_t"].value == pytest.approx(0.5, abs=1e-5)


def test_a_truth_on_the_bound_is_reached_and_marked():
    result = fitting.fit(studio(k_t=0.5), picture(studio(k_t=0.0)), ["glass.k_t", "glass.k_d"])
    assert result["glass.k_t"].value == pytest.approx(0, abs=1e-3)
    assert result["glass.k_t"].at_bound
    assert result["glass.k_d"].value == pytest.approx(0.3, abs=1e-3)


def test_what_no_pixel_sees_is_reported_and_gets_no_number():
    """The mirror stands behind the camera that is left."""
    scene = studio()
    away = Scene(
        objects=scene.objects,
        materials=scene.materials,
        lights=scene.lights,
        background=scene.background,
        cameras={"main": Camera((0, 0.5, -5), (0, 3, -20), 40, 20, 16)},
    )
    result = fitting.fit(away, picture(away), ["floor.k_d", "glass.k_a"])
    assert result.status == "not_identifiable"
    assert result.exit_code == 1
    assert not result["glass.k_a"].seen
    assert result["glass.k_a"].standard_error is None
    assert "glass.k_a" in result.message


def test_what_cannot_be_told_apart_is_reported_together():
    """Under ambient light alone, two camera views of one matte colour see only k_a; with an even highlight
    exponent of 0, k_h (N.H)^0 is a constant like k_a I_a wherever the light is in front."""
    scene = Scene(
        objects=[Plane("wall", (0, 0, 1), 0, "paint")],
        materials={"paint": Material(k_a=0.2, k_h=0.3, phong_exponent=0.0)},
        lights=[diffwhitted.DirectionalLight((0, 0, 1), (1, 1, 1))],
        cameras={"main": Camera((0, 0, 5), (0, 0, 0), 40, 16, 12)},
    )
    result = fitting.fit(scene, picture(scene), ["paint.k_a", "paint.k_h"])
    assert result.status == "not_identifiable"
    assert result["paint.k_a"].confounded_with == ("paint.k_h",)
    assert result["paint.k_h"].confounded_with == ("paint.k_a",)
    assert result["paint.k_a"].standard_error is None
    assert result.rank == 1


def test_the_index_is_fitted_before_a_smooth_background():
    """Glass alone before a gradient: nothing sharp moves, so the plain derivative is right."""

    def glass_ball(index):
        return Scene(
            objects=[Sphere("ball", (0, 0, 0), 1, "glass")],
            materials={"glass": Material(k_t=1.0, refractive_index=index)},
            background=diffwhitted.GradientBackground((0.9, 0.2, 0.1), (0.1, 0.3, 0.9)),
            cameras={"main": Camera((0, 0, 3), (0, 0, 0), 25, 24, 18)},
        )

    result = fitting.fit(glass_ball(1.3), picture(glass_ball(1.5)), ["glass.refractive_index"], footprint=0)
    assert result["glass.refractive_index"].value == pytest.approx(1.5, abs=1e-4)


def test_intervals_cover_the_truth_in_95_of_100_noisy_targets():
    """200 targets with noise of 0.02: for each coefficient the interval covers in 90 to 98.5 % of them."""
    scene, noise = studio(), 0.02
    names = ("glass.k_d", "glass.k_s", "glass.k_t")
    unknowns = list_unknowns(scene, names)
    truth = np.asarray([0.3, 0.2, 0.5])
    clean = as_targets(scene, picture(scene))
    problem, weighing = build(scene, clean, names, tied(unknowns, None), truth, 1, None, 0)
    (view,) = problem.views
    random, covered = np.random.default_rng(0), []
    for _ in range(200):
        noisy = clean[0].image + noise * random.normal(size=clean[0].image.shape)
        film = dealt(jnp.asarray(noisy, jnp.float32), view.passes, view.parts[0].plan.pass_pixels)
        noisy_problem = eqx.tree_at(lambda p: [part.target for part in p.views[0].parts], problem, list(film))
        best = solve(noisy_problem, truth, max_steps=30)
        noisy_targets = (replace(clean[0], image=noisy),)
        end = Settled(best, noisy_problem, weighing, "points", None, noisy_targets, False)
        result = outcome(scene, noisy_targets, end, truth, (), ())
        assert result.noise == pytest.approx(noise, rel=0.1)
        covered.append(
            [
                low <= t <= high
                for (low, high), t in zip((c.interval_95 for c in result.coefficients), truth, strict=True)
            ]
        )
    share = np.mean(covered, axis=0)
    assert np.all((share >= 0.90) & (share <= 0.985)), share


def test_several_starts_end_at_the_best():
    result = fitting.fit(studio(k_d=0.9), picture(studio()), ["glass.k_d", "glass.phong_exponent"], starts=3)
    assert result.starts_tried == 3
    assert result["glass.phong_exponent"].value == pytest.approx(20, rel=1e-4)


@pytest.mark.parametrize(
    "change, words",
    [
        (dict(free=["glas.k_d"]), ["glas.k_d", "Did you mean 'glass.k_d'"]),
        (dict(free=["*.k_x"]), ["*.k_x", "k_d"]),
        (dict(free=[]), ["free"]),
        (dict(free=["spare.k_d"]), ["spare.k_d", "no object is made of"]),
        (dict(free=["floor.phong_exponent"]), ["floor.phong_exponent", "k_h = 0"]),
        (dict(free=["floor.refractive_index"]), ["floor.refractive_index", "k_t = 0"]),
        (dict(targets=np.zeros((3, 4, 3))), ["4x3", "40x30"]),
        (dict(targets=np.zeros((30, 40))), ["(30, 40)", "(height, width, 3)"]),
        (dict(targets=np.full((30, 40, 3), np.nan)), ["1200 pixel(s) are NaN", "row 0, column 0", "mask"]),
        (dict(targets={"back": np.zeros((30, 40, 3))}), ["back", "main, side"]),
        (dict(targets=fitting.Target(np.zeros((30, 40, 3)), mask=np.zeros((30, 40)))), ["mask leaves no pixel"]),
        (dict(targets=fitting.Target(np.zeros((30, 40, 3)), noise=-1.0)), ["noise", "> 0"]),
        (dict(start={"glass.k_d": 1.5}), ["glass.k_d = 1.5", "0 to 1"]),
        (dict(start={"floor.k_d": 0.5}), ["floor.k_d", "not free", "glass.k_d"][0:1]),
        (dict(bounds={"glass.k_d": (0.5, 0.2)}), ["glass.k_d", "low < high"]),
        (dict(bounds={"glass.k_d": (-1, 1)}), ["glass.k_d", ">= 0"]),
        (dict(starts=0), ["starts = 0"]),
    ],
)
def test_bad_input_is_one_clear_error(change, words):
    given = {"targets": np.zeros((30, 40, 3)), "free": ["glass.k_d"]} | change
    with pytest.raises(fitting.FitError) as caught:
        fitting.fit(studio(), **given)
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_wildcards_pass_over_what_cannot_matter_and_say_so():
    result = fitting.fit(studio(), picture(studio()), ["*.k_d"])
    assert {c.name for c in result.coefficients} == {
        "glass.k_d",
        "chrome.k_d",
        "floor.k_d.r",
        "floor.k_d.g",
        "floor.k_d.b",
    }
    assert "spare.k_d left as it is: no object is made of 'spare'" in result.message


def test_one_channel_is_named_and_replaced():
    scene = replace_coefficient(studio(), "glass.k_d", (0.1, 0.2, 0.3))
    result = fitting.fit(scene, picture(scene), ["glass.k_d"], start={"glass.k_d.g": 0.9})
    assert [round(result[f"glass.k_d.{c}"].value, 4) for c in "rgb"] == [0.1, 0.2, 0.3]
    assert result["glass.k_d.g"].start == pytest.approx(0.9)
