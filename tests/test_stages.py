"""From coarse to fine: what the first stages of a fit look at, and that its end is that of a fit without them."""

import functools
import itertools
from collections import Counter
from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.scene import marks_of
from diffwhitted.tree import likely_room, make_plan
from fitting.judging._rest import off_bound
from fitting.problem import _views
from fitting.problem._sight import Sight
from fitting.problem._unknowns import list_unknowns
from fitting.problem._views import coarser, finer, some_passes, view_of
from fitting.solving import _stages

NAMES = ["ball.k_d", "ball.k_h", "ball.phong_exponent", "floor.k_d"]


@functools.cache
def studio():
    objects = [dw.Sphere("ball", (0, 0, 0), 1, "ball"), dw.Plane("ground", (0, 1, 0), -1, "floor")]
    materials = {
        "ball": dw.Material(k_d=0.6, k_h=0.3, phong_exponent=30),
        "floor": dw.Material(k_d=(0.2, 0.4, 0.7), k_h=0),
    }
    return dw.Scene(
        objects=objects,
        materials=materials,
        lights=[dw.PointLight((3, 5, 4), 1)],
        cameras={"main": dw.Camera((0, 1, 5), (0, 0, 0), 40, 48, 36)},
    )


SIGHT = Sight(*(jnp.int32(0),) * 2, (), *(jnp.zeros(0, jnp.int32),) * 2, ("main",), (0,), ())


def view(passes, random, footprint=0):
    """A view of noise, some of it masked."""
    scene = studio()
    camera = scene.cameras["main"]
    plan = make_plan(scene, camera, capacity=likely_room(camera), footprint=footprint, pass_of=-(-48 * 36 // passes))
    weight = random.uniform(0, 1, (36, 48)) * (random.uniform(size=(36, 48)) < 0.8)
    return view_of(
        SIGHT, random.uniform(size=(36, 48, 3)), weight, jnp.full((1, 2), 0.5), 1.0, plan.program, marks_of(scene)
    )


def test_some_passes_weigh_as_much_as_all():
    """Pixels from all over the picture, none twice."""
    whole = view(8, np.random.default_rng(0))
    some = some_passes(whole, 2)
    places = [
        (float(c), float(r))
        for part in some.parts
        for c, r, there in zip(part.column, part.row, part.there, strict=True)
        if there
    ]
    assert len(set(places)) == len(places) == 2 * 48 * 36 // 8
    weights = {
        (int(c), int(r)): w
        for part in some.parts
        for c, r, w, t in zip(part.column, part.row, part.weight[0], part.there, strict=True)
        if t
    }
    for (column, row), weight in weights.items():
        assert weight == pytest.approx(2 * whole.weight[row, column, 0], rel=1e-6)
    # 6 x 6 tiles of the picture, each with as many.
    assert Counter((int(column) // 8, int(row) // 6) for column, row in places) == {
        tile: 12 for tile in itertools.product(range(6), repeat=2)
    }


def test_squares_have_the_mean_of_their_pixels():
    """Weighted by the squares of the weights, so that a uniform residual counts as much as before; nothing where all
    is masked.
    """
    random = np.random.default_rng(1)
    whole = view(1, random, footprint=1)
    whole = replace(
        whole, weight=np.where(np.arange(36)[:, None, None] // 5 + np.arange(48)[:, None] // 5, whole.weight, 0)
    )
    coarse = coarser(whole, 5)  # 48 and 36 are no multiples of 5
    assert coarse.weight.shape == (8, 10, 3) and coarse.weight[0, 0, 0] == 0
    assert (coarse.weight**2).sum() == pytest.approx((whole.weight**2).sum())
    block, weight = whole.image[10:15, 20:25], whole.weight[10:15, 20:25] ** 2
    np.testing.assert_allclose(coarse.image[2, 4], (block * weight).sum((0, 1)) / weight.sum((0, 1)), rtol=1e-6)
    (part,) = coarse.parts
    samples = part.samples
    assert (float(samples.column[14]), float(samples.row[14]), float(samples.side)) == (22.5, 7.5, 5.0)
    np.testing.assert_allclose(np.asarray(coarse.picture(part.target[None])), coarse.image, rtol=1e-6)


def test_quarters_of_a_square():
    (part,) = view(1, np.random.default_rng(2), footprint=1).parts
    quarters = finer(eqx.tree_at(lambda v: v.parts, view(1, np.random.default_rng(2), footprint=1), (part,))).parts
    assert [tuple(map(float, quarter.place)) for quarter in quarters] == [
        (0.25, 0.25),
        (0.75, 0.25),
        (0.25, 0.75),
        (0.75, 0.75),
    ]
    assert all(float(quarter.side) == 0.5 for quarter in quarters)


def test_off_a_bound_is_inside_it():
    unknowns = list_unknowns(studio(), ["ball.k_d", "ball.k_h"])
    np.testing.assert_allclose(off_bound(np.array([0.0, 0.5]), unknowns), [0.01, 0.5])
    np.testing.assert_allclose(off_bound(np.array([1.0, 1 - 1e-5]), unknowns), [0.99, 0.99])


@pytest.fixture
def small_parts(monkeypatch):
    """Small pictures in as many passes as large ones have."""
    monkeypatch.setattr("fitting.problem._build.PART_PIXELS", 48 * 36 // 8)
    monkeypatch.setattr(_stages, "LEAST_SAMPLES", 48)


def test_the_end_is_that_of_a_fit_that_looks_at_all_pixels_from_the_start(small_parts):
    scene = studio()
    picture = np.asarray(dw.render(scene, scene.cameras["main"])) + 0.01 * np.random.default_rng(3).normal(
        size=(36, 48, 3)
    ).astype(np.float32)
    start = {"*.k_*": 0.5, "*.phong_exponent": 10}
    fits = {how: fitting.fit(scene, picture, NAMES, start=start, coarse_to_fine=how) for how in (True, False)}
    assert [stage.name for stage in fits[False].stages] == ["all pixels"]
    first, last = fits[True].stages
    assert first.name.startswith("one pixel in") and first.samples <= 48 * 36 // 4 and last.samples == 48 * 36
    assert last.steps < first.steps and first.steps + last.steps == fits[True].steps == len(fits[True].history)
    assert all(result.status == "converged" for result in fits.values())
    for coarse, fine in zip(fits[True].coefficients, fits[False].coefficients, strict=True):
        assert coarse.value == pytest.approx(fine.value, abs=0.02 * fine.standard_error)
        assert coarse.standard_error == pytest.approx(fine.standard_error, rel=1e-3)


def test_a_small_thing_that_no_first_pixel_shows_is_found_all_the_same(small_parts):
    """The mask leaves only pixels of passes that are not looked at first."""
    scene = studio()
    camera = scene.cameras["main"]
    picture = np.asarray(dw.render(scene, camera))
    pixel = np.arange(48 * 36).reshape(36, 48)
    result = fitting.fit(
        scene,
        fitting.Target(picture, mask=(pixel % 8 == 3).astype(float)),
        ["ball.k_d", "floor.k_d"],
        start={"*.k_d": 0.5},
    )
    assert result.status == "converged" and result["ball.k_d"].value == pytest.approx(0.6, abs=1e-4)


def test_an_interrupted_first_stage_ends_with_a_picture(small_parts, monkeypatch):
    scene = studio()
    picture = np.asarray(dw.render(scene, scene.cameras["main"]))
    real = _stages.solve

    def stopped_early(*problem, max_steps, **how):
        return replace(real(*problem, max_steps=min(max_steps, 2), **how), interrupted=max_steps > 1)

    monkeypatch.setattr(_stages, "solve", stopped_early)
    result = fitting.fit(scene, picture, ["ball.k_d", "floor.k_d"], start={"*.k_d": 0.5})
    assert result.status == "interrupted" and result.views[0].render.shape == (36, 48, 3)
    assert [stage.name for stage in result.stages][-1] == "all pixels"


def test_a_step_of_the_pyramid_leaves_pixels_enough():
    assert [_stages._step(480 * 640, blur) for blur in (64, 16, 8, 4, 1)] == [4, 4, 4, 2, 1]
    assert _views.PART_PIXELS >= _stages.LEAST_SAMPLES
