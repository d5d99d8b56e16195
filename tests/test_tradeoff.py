"""What accuracy costs in time: knobs, references, the Pareto front, choices, and the command that shows them."""

import dataclasses

import jax
import numpy as np
import pytest
from tradeoff_samples import SCENE, Candidate, brute_force

import diffwhitted as dw
from diffwhitted.accuracy import _survey
from diffwhitted.accuracy._choose import _for_budget, spread_pixels
from diffwhitted.accuracy._reference import reference, rmse
from diffwhitted.accuracy._survey import cheapest, front, survey
from diffwhitted.accuracy._tracer import Tracer


@pytest.fixture(scope="module")
def tracer():
    scene = dw.parse_scene(SCENE)
    return Tracer(scene, scene.cameras["main"])


@pytest.fixture(scope="module")
def truth(tracer):
    return reference(tracer, wanted=lambda refined: 1e-3)


@pytest.fixture(scope="module")
def candidates(tracer, truth):
    return survey(tracer, truth.pixels, tracer.all_pixels)


@pytest.fixture(scope="module")
def choices(tracer):
    return {tolerance: dw.choose(tracer.scene, tracer.camera, tolerance=tolerance) for tolerance in (0.04, 0.01)}


# Knobs and settings.


def test_every_knob_is_a_field_with_a_row():
    assert [knob.name for knob in dw.KNOBS] == [field.name for field in dataclasses.fields(dw.Settings)]
    assert all(knob.costs and knob.controls and len(knob.sweep) > 1 for knob in dw.KNOBS)
    assert all(dw.Settings().only(**{knob.name: value}) for knob in dw.KNOBS for value in knob.sweep)


@pytest.mark.parametrize(
    "values, text",
    [
        ({}, "depth 5, 1 point"),
        ({"depth": 4, "footprint": 1}, "depth 4, footprint 1"),
        ({"samples": 4}, "depth 5, 4 x 4 points"),
        ({"cutoff": 1 / 256, "antialias": 0.1}, "depth 5, cutoff 0.0039, antialias 0.1"),
        ({"precision": "float64"}, "depth 5, float64, 1 point"),
    ],
)
def test_settings_read_as_text(values, text):
    assert str(dw.Settings(**values)) == text


@pytest.mark.parametrize(
    "values, message",
    [
        ({"depth": 0}, "depth = 0"),
        ({"cutoff": 1}, "cutoff = 1"),
        ({"samples": 1.5}, "samples = 1.5"),
        ({"footprint": -1}, "footprint = -1"),
        ({"antialias": -0.1}, "antialias = -0.1"),
        ({"precision": "half"}, "precision = 'half'"),
        ({"shading": "blinn"}, "shading = 'blinn'"),
        ({"samples": 2, "footprint": 1}, "one of the two"),
    ],
)
def test_settings_that_are_none_are_refused(values, message):
    with pytest.raises(dw.SceneError, match=message):
        dw.Settings(**values)


def test_a_sweep_turns_off_what_excludes_it():
    base = dw.Settings(depth=3, footprint=1)
    assert base.only(samples=3) == dw.Settings(depth=3, samples=3)
    assert len(base.alternatives("tree")) == len(dw.KNOBS[0].sweep) * len(dw.KNOBS[1].sweep)
    assert all(other.depth == 3 for other in base.alternatives("pixel"))


# Pictures.


@pytest.mark.parametrize("values", [{"depth": 3, "samples": 2, "cutoff": 0.35}, {"depth": 2, "footprint": 1}])
def test_a_tracer_gives_the_picture_of_render(tracer, values):
    settings = dw.Settings(**values)
    image = dw.render(tracer.scene, tracer.camera, **settings.options())
    np.testing.assert_allclose(tracer.trace(settings).pixels, np.asarray(image).reshape(-1, 3), atol=1e-6)
    some = np.arange(5, 700, 7)
    np.testing.assert_allclose(
        tracer.trace_spread(settings, some).pixels, np.asarray(image).reshape(-1, 3)[some], atol=1e-6
    )


def test_pixels_that_need_more_room_are_dealt_to_more_passes(tracer):
    small = Tracer(tracer.scene, tracer.camera)
    settings = dw.Settings(depth=4)
    small._plans[False, settings.light_samples, "stated", None] = small.plan(settings).with_capacity(1)
    assert small.trace(settings).rays == tracer.trace(settings).rays > small.plan(settings).capacity
    np.testing.assert_allclose(small.trace(settings).pixels, tracer.trace(settings).pixels, atol=1e-6)


def test_what_a_tracer_leaves_out_is_the_bound_of_render_with_bound(tracer):
    settings = dw.Settings(depth=3, samples=2, cutoff=0.35)
    bound = dw.render_with_bound(tracer.scene, tracer.camera, **settings.options())
    np.testing.assert_allclose(tracer.left_out(settings), bound.left_out.reshape(-1, 3), atol=1e-6)
    assert bound.most > 0.1 and tracer.left_out(dw.Settings(antialias=0.1)) is None


@pytest.mark.parametrize("values", [{"depth": 1}, {"depth": 2, "footprint": 1}, {"depth": 16, "cutoff": 0.4}])
def test_what_is_missing_is_within_the_bound(tracer, values):
    settings = dw.Settings(**values)
    missing = tracer.trace(dataclasses.replace(settings, depth=32, cutoff=0.0)).pixels - tracer.trace(settings).pixels
    assert missing.min() > -1e-5 and (missing <= tracer.left_out(settings) + 1e-5).all() and missing.max() > 0.05


def test_measure_gives_image_rays_and_seconds(tracer):
    found = dw.measure(tracer.scene, tracer.camera, dw.Settings(depth=1, samples=3))
    np.testing.assert_array_equal(found.image.reshape(-1, 3), tracer.trace(found.settings).pixels.astype(np.float32))
    assert found.rays == 9 * 32 * 24 and found.image.dtype == np.float32 and found.seconds > 0


def test_references_converge_to_many_points(tracer, truth):
    """n x n points on a grid err by about 1/n of what one point does."""
    one, many = (tracer.trace(dw.Settings(depth=16, samples=n)).pixels for n in (1, 24))
    assert rmse(many, truth.pixels) < 2 / 24 * rmse(one, truth.pixels)
    assert truth.difference <= 1e-3 and rmse(truth.before, truth.pixels) == truth.difference


# Surveys, fronts and choices.


@pytest.mark.parametrize("seed", range(20))
def test_the_front_is_what_nothing_else_beats(seed):
    grid = (
        np.random.default_rng(seed).integers(0, 6, (25, 2)) if seed % 2 else np.random.default_rng(seed).random((25, 2))
    )
    points = [Candidate(*pair) for pair in grid]
    assert front(points) == brute_force(points)


def test_combinations_are_foretold(tracer, truth, candidates):
    together = [
        c
        for c in candidates
        if c.settings.depth in (1, 4)
        and c.settings.samples in (2, 4)
        or c.settings == dw.Settings(depth=4, footprint=2)
    ]
    assert len(together) > 4
    for found in together:
        traced = tracer.trace(found.settings)
        assert found.error == pytest.approx(rmse(traced.pixels, truth.pixels), rel=0.25)
        assert found.rays == pytest.approx(traced.rays, rel=0.1)


def test_a_tighter_tolerance_costs_no_less(candidates):
    costs = [
        cheapest(candidates, tolerance).seconds for tolerance in np.geomspace(1, min(c.error for c in candidates), 40)
    ]
    assert costs == sorted(costs) and costs[0] < costs[-1]


def test_the_tolerance_is_met_on_the_check_and_on_the_whole(choices, truth):
    for tolerance, found in choices.items():
        assert found.error <= tolerance
        assert rmse(found.measured.image.reshape(-1, 3), truth.pixels) <= 1.2 * tolerance
    assert choices[0.01].settings != choices[0.04].settings


def test_a_time_budget_is_spent_on_the_most_accurate(tracer):
    found = dw.choose(tracer.scene, tracer.camera, time_budget=1e4)
    assert found.error <= 2 * min(c.error for c in found.candidates)


def test_a_time_budget_is_kept_where_pictures_take_longer_than_foretold():
    """Each takes twice its time: of 9 s the 8 s are foretold to fit, and 4 s do."""
    seconds = {depth: float(depth) for depth in (1, 2, 4, 8)}
    candidates = [_survey.Candidate(dw.Settings(depth=d), 1 / d, 100.0, s) for d, s in seconds.items()]
    tried = []

    def trial(settings):
        tried.append(settings.depth)
        taken = 2 * seconds[settings.depth]
        return dw.Measured(settings, np.zeros((1, 1, 3)), 100, taken, 0.0), 1 / settings.depth

    measured, error = _for_budget(candidates, 9.0, trial, 1.0)
    assert (measured.settings.depth, measured.seconds, error, tried) == (4, 8.0, 0.25, [8, 4])


def test_render_takes_a_tolerance(tracer):
    wide = dw.render(tracer.scene, tracer.camera, tolerance=10.0)
    np.testing.assert_allclose(np.reshape(wide, (-1, 3)), tracer.trace(dw.Settings(depth=1)).pixels, atol=1e-6)
    with pytest.raises(dw.SceneError, match="give it alone"):
        dw.render(tracer.scene, tracer.camera, tolerance=0.1, samples=2)


@pytest.mark.parametrize(
    "bound, message",
    [
        ({}, "one of the two"),
        ({"tolerance": 0.1, "time_budget": 1}, "one of the two"),
        ({"tolerance": 0}, "tolerance = 0"),
        ({"tolerance": "a"}, "tolerance = 'a'"),
        ({"time_budget": float("nan")}, "time budget = nan"),
        ({"tolerance": 1e-9}, "no settings of the table are so accurate here; .* so ask for"),
        ({"time_budget": 1e-9}, "cheapest settings of the table"),
    ],
)
def test_bounds_that_cannot_be_met_are_refused(tracer, bound, message):
    with pytest.raises(dw.InputError, match=message):
        dw.choose(tracer.scene, tracer.camera, **bound)


def test_nothing_can_be_chosen_for_traced_values(tracer):
    with pytest.raises(dw.InputError, match="outside jit"):
        jax.jit(lambda s: dw.render(s, tracer.camera, tolerance=0.1))(tracer.scene)


@pytest.mark.parametrize("pixels, most", [(1, 10), (100, 100), (1000, 64), (1000, 999)])
def test_spread_pixels_are_different_ones(pixels, most):
    chosen = spread_pixels(pixels, most)
    assert len(set(chosen)) == min(pixels, most) and chosen.max() < pixels
