"""What accuracy costs in time: knobs, references, the Pareto front, choices, and the command that shows them."""

import csv
import dataclasses
import json
import re

import jax
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.accuracy import _survey
from diffwhitted.accuracy._choose import _for_budget, spread_pixels
from diffwhitted.accuracy._reference import reference, rmse
from diffwhitted.accuracy._survey import cheapest, front, survey
from diffwhitted.accuracy._tracer import Tracer
from fitting.command_line import main
from fitting.command_line._accuracy import tolerance_number
from fitting.comparing._fit_knobs import FIT_KNOBS
from fitting.comparing._tradeoff import CONVERGED, Point, Tradeoff, bound_text, bound_value, recommendation, sentences
from fitting.comparing._tradeoff_fit import tradeoff_of_fits

SCENE = """
[scene]
background = [0.2, 0.3, 0.5]
max_depth = 2

[[camera]]
look_from = [0, 1, 5]
look_at = [0, 0, 0]
vfov_deg = 40
width = 32
height = 24

[[light]]
type = "directional"
direction = [1, 2, 2]
colour = [0.8, 0.8, 0.8]

[[texture]]
name = "tiles"
type = "checker"
colours = [[0.1, 0.1, 0.1], [1, 1, 1]]
axes = "xz"

[[material]]
name = "mirror"
k_a = 0.1
k_s = 0.8

[[material]]
name = "floor"
k_d = 0.8
k_s = 0.4
k_d_texture = "tiles"

[[object]]
name = "ball"
type = "sphere"
centre = [0, 0, 0]
radius = 1
material = "mirror"

[[object]]
name = "ground"
type = "plane"
normal = [0, 1, 0]
offset = -1
material = "floor"
"""
FILES = {"tradeoff.json", "tradeoff.csv", "tradeoff.png", "tradeoff-fit.csv", "tradeoff-fit.png", "tradeoff.html"}


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


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the command has been run."""
    folder = tmp_path_factory.mktemp("tradeoff")
    (folder / "scene.toml").write_text(SCENE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        few = [
            dataclasses.replace(knob, sweep={"depth": (2,), "samples": (1, 3)}.get(knob.name, knob.sweep[:1]))
            for knob in FIT_KNOBS
        ]
        patch.setitem(tradeoff_of_fits.__kwdefaults__, "knobs", few)
        patch.setitem(tradeoff_of_fits.__kwdefaults__, "combinations", ())
        arguments = [
            "--out",
            str(folder / "out"),
            "--tolerance",
            "1/50",
            "--free",
            "mirror.k_[as]",
            "--free",
            "floor.k_s",
        ]
        assert main(["tradeoff", str(folder / "scene.toml"), *arguments]) == 0
    yield folder
    jax.config.update("jax_compilation_cache_dir", None)


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
    small._plans[False] = small.plan(settings).with_capacity(1)
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


def brute_force(points):
    return [
        not any(
            o.seconds <= p.seconds and o.error <= p.error and (o.seconds < p.seconds or o.error < p.error)
            for o in points
        )
        for p in points
    ]


@pytest.mark.parametrize("seed", range(20))
def test_the_front_is_what_nothing_else_beats(seed):
    grid = (
        np.random.default_rng(seed).integers(0, 6, (25, 2)) if seed % 2 else np.random.default_rng(seed).random((25, 2))
    )
    points = [Candidate(*pair) for pair in grid]
    assert front(points) == brute_force(points)


@dataclasses.dataclass
class Candidate:
    seconds: float
    error: float


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


# What is said.


def measured(*points, difference=1e-4, tolerance=1 / 255):
    made = [Point(settings, ("depth",), error, 1.0, 1.0, 2.0, 100, seconds, 0.5) for settings, error, seconds in points]
    marks = front(made, error=lambda p: p.rmse)
    made = tuple(dataclasses.replace(p, on_front=mark) for p, mark in zip(made, marks, strict=True))
    return Tradeoff(8, 6, made, dw.Settings(), tolerance, "many trees", difference, 5, 1.0, np.zeros((6, 8, 3)))


OWN, FINE, FINER = (
    (dw.Settings(), 0.05, 0.01),
    (dw.Settings(depth=4, footprint=1), 0.0035, 0.21),
    (dw.Settings(footprint=2), 0.002, 0.651),
)


def test_the_recommendation_names_settings_cost_and_the_next_step():
    assert recommendation(measured(OWN, FINE, FINER)) == (
        "For 1/255: depth 4, footprint 1: 210 ms, error 0.0035; the next step down in error, depth 5, footprint 2 "
        "with 0.002, costs 3.1 times."
    )
    assert recommendation(measured(OWN, FINE)).endswith("No setting here is more accurate by a fifth or more.")
    assert "no setting is so accurate here; the nearest is depth 4, footprint 1: error 0.0035" in recommendation(
        measured(OWN, FINE, tolerance=1e-3)
    )


def test_a_reference_that_has_not_converged_is_called_so():
    good, bad = measured(OWN, FINE, difference=3e-4), measured(OWN, FINE, difference=4e-4)
    assert (good.converged, bad.converged) == (True, False)
    assert sentences(good)[2].endswith("1/12 of the smallest error.")
    assert (
        "more than a tenth of the smallest error, 0.0035: it has not converged, and errors below 0.004 are uncertain"
        in sentences(bad)[2]
    )


def test_an_infinite_bound_is_said_in_words():
    assert [(bound_value(bound), bound_text(bound)) for bound in (None, np.inf, 0.0, 0.123, 112.4)] == [
        (None, "not bounded"),
        ("Infinity", "infinite"),
        (0.0, "0"),
        (0.123, "0.12"),
        (112.4, "112"),
    ]


# The command.


def test_the_command_leaves_files_that_can_be_read(folder):
    assert {path.name for path in (folder / "out").iterdir()} == FILES
    found = json.loads((folder / "out/tradeoff.json").read_text())
    rows = list(csv.DictReader((folder / "out/tradeoff.csv").read_text().splitlines()))
    assert len(rows) == len(found["points"]) > 20
    assert set(found["points"][0]["settings"]) == {knob.name for knob in dw.KNOBS} <= set(rows[0])
    assert {sweep for point in found["points"] for sweep in point["sweeps"]} >= {knob.name for knob in dw.KNOBS}
    assert found["reference"]["converged"] == (
        found["reference"]["difference"] <= CONVERGED * min(p["rmse"] for p in found["points"])
    )
    made = [Candidate(p["seconds"], p["rmse"]) for p in found["points"]]
    assert (
        [p["on_front"] for p in found["points"]] == front(made) == brute_force([dataclasses.replace(c) for c in made])
    )
    bounds = {point["text"]: point["bound"] for point in found["points"]}
    by_depth = [bounds[f"depth {depth}, footprint 1"] for depth in (1, 2, 3, 4)]
    assert by_depth == sorted(by_depth, reverse=True) and bounds["depth 2, antialias 0.1"] is None
    assert [row["bound"] for row in rows] == [
        "" if point["bound"] is None else str(point["bound"]) for point in found["points"]
    ]
    page = (folder / "out/tradeoff.html").read_text()
    assert "<svg" in page and not re.search(r"""(src|href)=["']?(https?:|//)""", page)
    assert (folder / "out/tradeoff.png").read_bytes().startswith(b"\x89PNG")


def test_fits_are_in_the_files_too(folder):
    found = json.loads((folder / "out/tradeoff.json").read_text())["fit"]
    rows = list(csv.DictReader((folder / "out/tradeoff-fit.csv").read_text().splitlines()))
    points = {point["text"]: point for point in found["points"]}
    assert set(points) == {"depth 2, 1 point", "depth 2, 3 x 3 points"} and len(rows) == 2
    assert found["truth"] == pytest.approx({"mirror.k_a": 0.1, "mirror.k_s": 0.8, "floor.k_s": 0.4})
    assert list(found["start"].values()) == pytest.approx([0.5, 0.5, 0.5])
    for row, point in zip(rows, found["points"], strict=True):
        errors = {name: abs(c["value"] - found["truth"][name]) for name, c in point["coefficients"].items()}
        assert {name: float(row[f"{name} error"]) for name in errors} == pytest.approx(errors)
        assert point["largest"] == pytest.approx(max(errors.values()), abs=1e-6) and row["largest_of"] == max(
            errors, key=errors.get
        )
    assert points["depth 2, 3 x 3 points"]["largest"] < points["depth 2, 1 point"]["largest"]
    page = (folder / "out/tradeoff.html").read_text()
    assert found["sentence"] in page and page.count("<svg") == 2
    assert (folder / "out/tradeoff-fit.png").read_bytes().startswith(b"\x89PNG")


def test_render_remembers_what_it_found(folder, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
    arguments = ["render", str(folder / "scene.toml"), "-o", str(folder / "a.exr"), "--tolerance", "1/20"]
    assert main(arguments) == 0 and main(arguments) == 0
    first, again = re.findall("^within 1/20: .*$", capsys.readouterr().out, re.M)
    assert again == f"{first} (found before; .scene.choices.json)"
    assert re.search(
        r"error 0\.0\d+ \(RMSE, linear RGB\) on 384 pixels that the search did not see, against 8 x 8 filtered trees",
        first,
    )


def test_a_choice_that_cannot_be_kept_is_made_all_the_same(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / ".scene.choices.json").mkdir()
    assert main(["render", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "a.exr"), "--time-budget", "5"]) == 0
    assert "in 5 s: depth " in capsys.readouterr().out
    assert sorted(path.name for path in tmp_path.iterdir()) == [".scene.choices.json", "a.exr", "scene.toml"]


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["tradeoff", "--tolerance", "0"], "--tolerance 0: allowed is a number above 0, or a fraction such as 1/255"),
        (["tradeoff", "--tolerance", "1/0"], "--tolerance 1/0: allowed"),
        (["tradeoff", "--camera", "side"], "--camera side: there is no such camera"),
        (["tradeoff", "--free", "mirror.k_x", "--out", "new"], "'mirror.k_x' matches no coefficient"),
        (["tradeoff", "--start", "mirror.k_s=0.2"], "--start without --free"),
        (["tradeoff", "--free", "mirror.k_s", "--start", "mirror.k_s=2"], "outside its bounds 0 to 1"),
        (["tradeoff", "--out", "scene.toml"], "cannot write scene.toml"),
        (["render", "-o", "a.exr", "--tolerance", "x"], "--tolerance x: allowed"),
        (["render", "-o", "a.exr", "--tolerance", "1/9", "--time-budget", "1"], "one of the two"),
        (["render", "-o", "a.exr", "--time-budget", "nan"], "--time-budget nan: allowed"),
        (["render", "-o", "a.exr", "--tolerance", "1/9", "--depth", "3"], "--tolerance with --depth"),
    ],
)
def test_bad_input_is_one_message(folder, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(folder)
    assert main([arguments[0], "scene.toml", *arguments[1:]]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1 and error.startswith("error: ")
    assert not (folder / "new").exists()


@pytest.mark.parametrize("text, value", [("1/255", 1 / 255), ("0.004", 0.004), ("1e-3", 1e-3), (" 1 / 64", 1 / 64)])
def test_a_tolerance_is_a_number_or_a_fraction(text, value):
    assert tolerance_number(text) == pytest.approx(value)
