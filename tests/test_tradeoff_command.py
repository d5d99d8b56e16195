"""`diffwhitted tradeoff` and `render --tolerance`: what they say, and what they write."""

import csv
import dataclasses
import json
import re

import numpy as np
import pytest
from tradeoff_samples import SCENE, Candidate, brute_force

import diffwhitted as dw
from diffwhitted.accuracy._survey import front
from fitting.command_line import main
from fitting.command_line._accuracy import tolerance_number
from fitting.comparing._fit_knobs import FIT_KNOBS
from fitting.comparing._tradeoff import CONVERGED, Point, Tradeoff, bound_text, bound_value, recommendation, sentences
from fitting.comparing._tradeoff_fit import tradeoff_of_fits

FILES = {"tradeoff.json", "tradeoff.csv", "tradeoff.png", "tradeoff-fit.csv", "tradeoff-fit.png", "tradeoff.html"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the command has been run."""
    folder = tmp_path_factory.mktemp("tradeoff")
    (folder / "scene.toml").write_text(SCENE)
    with pytest.MonkeyPatch.context() as patch:
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
    return folder


def measured(*points, difference=1e-4, tolerance=1 / 255):
    made = [Point(settings, ("depth",), error, 1.0, 1.0, 2.0, 100, seconds, 0.5) for settings, error, seconds in points]
    marks = front(made, error=lambda p: p.rmse)
    made = tuple(dataclasses.replace(p, on_front=mark) for p, mark in zip(made, marks, strict=True))
    return Tradeoff(8, 6, made, dw.Settings(), tolerance, "many trees", difference, 5, 1.0, np.zeros((6, 8, 3)))


NOT_HERE = "light_samples", "shading", "fresnel", "roughness_samples", "blur_samples"
"""No lamp has a size, nothing is a mesh, nothing is weighed by the angle or rough."""
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


def test_the_command_leaves_files_that_can_be_read(folder):
    assert {path.name for path in (folder / "out").iterdir()} == FILES
    found = json.loads((folder / "out/tradeoff.json").read_text())
    rows = list(csv.DictReader((folder / "out/tradeoff.csv").read_text().splitlines()))
    assert len(rows) == len(found["points"]) > 20
    assert set(found["points"][0]["settings"]) == {knob.name for knob in dw.KNOBS} <= set(rows[0])
    assert {sweep for point in found["points"] for sweep in point["sweeps"]} >= {
        knob.name for knob in dw.KNOBS if knob.name not in NOT_HERE
    }
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
    arguments = ["render", str(folder / "scene.toml"), "-o", str(folder / "a.exr"), "--tolerance", "1/20"]
    assert main(arguments) == 0 and main(arguments) == 0
    first, again = re.findall("^within 1/20: .*$", capsys.readouterr().out, re.M)
    assert again == f"{first} (found before; .scene.choices.json)"
    assert re.search(
        r"error 0\.0\d+ \(RMSE, linear RGB\) on 384 pixels that the search did not see, against 8 x 8 filtered trees",
        first,
    )


def test_a_choice_that_cannot_be_kept_is_made_all_the_same(folder, tmp_path, monkeypatch, capsys):
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
