"""The result of a fit and what is written of it: JSON, page, terminal table, files."""

import dataclasses
import html
import json
import os
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from diffwhitted.image import read_image
from fitting._result import FitResult, FitStep, FittedCoefficient, FitView
from fitting.telling import _outputs
from fitting.telling._outputs import OutputError, write_outputs
from fitting.telling._report import report_html
from fitting.telling._tables import (
    coefficient_table,
    deviation_text,
    interval_text,
    places,
    rounded,
    rounded_error,
    seconds_text,
    summary_lines,
)

ODD = '<b>&"glass".k_d'
TITLE = "<script>alert('a')</script> & \"b\""


def coefficient(name, value, error=None, **others):
    known = dict(
        symbol="k_d",
        start=0.5,
        identifiable=error is not None,
        seen=True,
        confounded_with=(),
        at_bound=False,
        bounds=(0.0, 1.0),
        unit="1",
        standard_error=error,
        interval_95=None if error is None else (value - 1.96 * error, value + 1.96 * error),
    )
    return FittedCoefficient(name=name, value=value, **(known | others))


def view(camera="main", height=6, width=8):
    random = np.random.default_rng(3)
    target = random.random((height, width, 3)).astype(np.float32)
    weight = np.ones((height, width), np.float32)
    weight[0] = 0
    residual = (random.normal(0, 0.01, target.shape) * weight[..., None]).astype(np.float32)
    return FitView(camera, target, target + residual, residual, weight)


@pytest.fixture
def result():
    coefficients = (
        coefficient(ODD, 0.120345678, 0.00042),
        coefficient("floor.k_d.r", 0.3, seen=False),
        coefficient("glass.k_s", 0.41, confounded_with=("glass.k_h", "glass.k_a")),
        coefficient("glass.k_t", 1.0, 0.002, at_bound=True, interval_95=(0.996, 1.0)),
        coefficient("glass.phong_exponent", 50.3141, 0.27, symbol="n", bounds=(1.0, 1000.0)),
    )
    correlation = np.eye(5)
    correlation[0, 4] = correlation[4, 0] = -0.93
    correlation[1:3] = correlation[:, 1:3] = np.nan
    return FitResult(
        status="not_identifiable",
        message="stopped: a <small> step",
        coefficients=coefficients,
        correlation=correlation,
        rank=3,
        rmse=0.01,
        noise=float("nan"),
        noise_given=False,
        steps=3,
        history=tuple(FitStep(i, 10.0**-i, 0.1 * i, i != 1) for i in range(3)),
        seconds_compile=2.0,
        seconds_solve=0.5,
        starts_tried=1,
        effects=(("shadows", True, "light <1>"), ("refraction", False, "no k_t")),
        views=(view(),),
        scene={"the": "scene"},
        free=("glass.*",),
    )


def save_scene(scene, path):
    assert path.suffix == ".toml"
    path.write_text(str(scene))


class Page(HTMLParser):
    """Tags with their attributes, the texts of `data` elements, and all text outside style and script."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.data, self.words, self._inside = [], [], "", []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag in ("style", "script", "data"):
            self._inside.append(tag)

    def handle_endtag(self, tag):
        if self._inside and self._inside[-1] == tag:
            self._inside.pop()

    def handle_data(self, text):
        if self._inside[-1:] == ["data"]:
            self.data.append(text)
        if not {"style", "script"} & set(self._inside):
            self.words += text


def refuse(token):
    raise AssertionError(f"{token} is no JSON")


def test_json_is_strict_and_complete(result):
    content = json.loads(json.dumps(result.to_json(), allow_nan=False), parse_constant=refuse)
    assert content["noise"] is None and content["correlation"][1][1] is None
    assert content["correlation"][0][4] == -0.93
    assert content["seconds"] == {"compile": 2.0, "solve": 0.5}
    assert list(content["coefficients"]) == [c.name for c in result.coefficients]
    first = content["coefficients"][ODD]
    assert first["value"] == 0.120345678 and first["standard_error"] == 0.00042
    unseen = content["coefficients"]["floor.k_d.r"]
    assert unseen["standard_error"] is None and unseen["interval_95"] is None and not unseen["identifiable"]
    assert content["views"][0]["pixels"] == 40
    assert {"status", "message", "rank", "rmse", "steps", "effects"} <= set(content)


def test_json_takes_numpy_numbers_and_infinite_bounds(result):
    numpy_one = coefficient("a.k_d", np.float32(0.5), np.float32(0.25), bounds=(0.0, np.inf), at_bound=np.bool_(False))
    changed = dataclasses.replace(result, coefficients=(numpy_one,), correlation=np.ones((1, 1)), rank=np.int64(1))
    content = json.loads(json.dumps(changed.to_json(), allow_nan=False))
    assert content["coefficients"]["a.k_d"]["bounds"] == [0.0, None]
    assert not re.search(r"\b(inf|nan)\b", Page(report_html(changed, title="t")).words)


@pytest.mark.parametrize(
    "status, code", [("converged", 0), ("not_converged", 1), ("not_identifiable", 1), ("interrupted", 1)]
)
def test_exit_code(result, status, code):
    assert dataclasses.replace(result, status=status).exit_code == code


def test_records_refuse_what_cannot_be(result):
    with pytest.raises(ValueError, match="a.k_d: .* not identifiable"):
        coefficient("a.k_d", 0.5, 0.1, identifiable=False)
    with pytest.raises(ValueError, match=r"\(5, 5\) is needed"):
        dataclasses.replace(result, correlation=np.eye(4))
    with pytest.raises(ValueError, match="converged, not_converged"):
        dataclasses.replace(result, status="fine")
    with pytest.raises(ValueError, match="'main': render has shape"):
        FitView("main", np.zeros((2, 3, 3)), np.zeros((3, 2, 3)), np.zeros((2, 3, 3)), np.zeros((2, 3)))


def test_lookup_by_name(result):
    assert result["glass.k_t"].value == 1.0
    with pytest.raises(KeyError, match="did you mean floor.k_d.r"):
        result["floor.k_d"]
    with pytest.raises(KeyError, match="did you mean glass.phong_exponent"):
        result["glass.fong_exponent"]


def test_remarks(result):
    assert result[ODD].remark == ""
    assert result["floor.k_d.r"].remark == "no pixel depends on it"
    assert result["glass.k_s"].remark == "cannot be told apart from glass.k_h and glass.k_a"
    assert result["glass.k_t"].remark == "at its upper bound 1"


@pytest.mark.parametrize(
    "value, error, text, error_text",
    [
        (0.120345678, 0.00042, "0.1203", "0.0004"),
        (0.120345678, 0.00012, "0.12035", "0.00012"),
        (0.3, 0.0999, "0.30", "0.10"),
        (50.3141, 0.27, "50.31", "0.27"),
        (123456.0, 4321.0, "123000", "4000"),
        (-1e-9, 0.01, "0.000", "0.010"),
        (0.5, 3e-12, "0.5000000", "3e-12"),
        (0.5, 0.0, "0.5000000", "0"),
        (float("nan"), 0.1, "not finite", "0.10"),
    ],
)
def test_rounding_follows_the_standard_error(value, error, text, error_text):
    assert rounded(value, error) == text
    assert rounded_error(error) == error_text


def test_texts():
    assert rounded(31.6227766, None) == "31.62"
    assert interval_text(coefficient("a.k_d", 0.12, 0.0004)) == "0.1192 to 0.1208"
    assert deviation_text(coefficient("a.k_d", 0.1203, 0.0004), 0.12) == "+0.25 %"
    assert deviation_text(coefficient("a.k_d", 0.01, 0.01), 0.0) == "+0.01"
    assert [seconds_text(t) for t in (0.417, 12.34, 59.96, 185.2)] == ["0.42 s", "12.3 s", "1 min 00 s", "3 min 05 s"]
    bar = places(coefficient("a.n", 10.0, 90.0, bounds=(1.0, 1000.0)), 1000.0)
    assert bar["logarithmic"] and bar["value"] == pytest.approx(33.333) and bar["truth"] == 100
    assert bar["ends"] == [0, pytest.approx(75.682)]  # log(186.4) / log(1000)


def test_page_holds_all_it_shows(result):
    text = report_html(result, title="t")
    page = Page(text)
    for tag, attributes in page.tags:
        assert tag not in ("iframe", "object", "embed", "base")
        for name in ("src", "href", "xlink:href", "srcset", "action"):
            assert attributes.get(name, "data:").startswith(("data:", "#")), (tag, attributes)
    assert not re.search(r"(https?:)?//[a-z]|@import", re.sub(r"data:image/png;base64,[\w+/=]+", "", text))
    assert set(re.findall(r"url\((.)", text)) == {"#"}
    pictures = [attributes for tag, attributes in page.tags if tag == "img"]
    assert len(pictures) == 4 and all(picture["alt"] for picture in pictures)


def test_page_escapes_what_it_is_given(result):
    text = report_html(dataclasses.replace(result, views=(view("<i>left"),)), title=TITLE)
    page = Page(text)
    assert [tag for tag, _ in page.tags].count("script") == 1 and TITLE in page.words
    assert not {"b", "i"} & {tag for tag, _ in page.tags}
    for words in (ODD, "<i>left", "stopped: a <small> step", "light <1>"):
        assert words in page.words and words not in text.replace(html.escape(words), "")


def test_page_numbers_are_the_results(result):
    truth = {ODD: 0.12}
    page = Page(report_html(result, title="t", truth=truth))
    values = [float(attributes["value"]) for tag, attributes in page.tags if tag == "data"]
    expected = []
    for known in result.coefficients:
        expected += [known.value] if known.standard_error is None else [known.value, known.standard_error]
    assert values == expected
    assert page.data == ["0.1203", "0.0004", "(0.3)", "(0.41)", "1.0000", "0.0020", "50.31", "0.27"]
    for words in (
        "0.1195 to 0.1212",
        "no pixel depends on it",
        "cannot be told apart from glass.k_h",
        "+0.29 %",
        "−.93",
    ):
        assert words in page.words
    assert "3 of 5" in page.words and "2 of the 5 coefficients are not determined" in page.words
    assert "Truth" not in Page(report_html(result, title="t")).words


def test_page_of_a_fit_with_little_to_show(result):
    bare = dataclasses.replace(result, views=(), history=(), effects=(), coefficients=(), correlation=np.zeros((0, 0)))
    words = Page(report_html(bare, title="t")).words
    assert "kept no pictures" in words and "No step was recorded" in words


def test_page_of_pictures_with_nothing_in_them(result):
    blank = np.zeros((4, 5, 3), np.float32)
    nothing = FitView("a", np.full_like(blank, np.nan), blank, blank, np.zeros((4, 5)))
    same = FitView("b", blank, blank, blank, np.ones((4, 5)))
    words = Page(report_html(dataclasses.replace(result, views=(nothing, same)), title="t")).words
    assert "0.0 % of them used" in words and "No pixel differs" in words
    assert "Noiseunknown" in words and "nan" not in words


@pytest.mark.parametrize("truth", [None, {"glass.k_t": 1.0, "glass.phong_exponent": 50.0}])
def test_terminal_table_reads_at_80_columns(result, truth):
    console = Console(width=80, no_color=True, record=True, file=open(os.devnull, "w"))
    with console.file:
        console.print(coefficient_table(result, truth))
    text = console.export_text()
    assert max(map(len, text.splitlines())) <= 80 and "…" not in text
    for words in (ODD, "0.1203 ± 0.0004", "50.31 ± 0.27", "(0.41)", "floor.k_d.r: no pixel depends on it"):
        assert words in text
    assert ("+0.63 %" in text) == (truth is not None)


LONG = "a_rather_long_material_name_of_the_left_hand_ball"


@pytest.mark.parametrize("truth", [None, {f"{LONG}.phong_exponent": 123.4, "b.k_d": 0.5}])
@pytest.mark.parametrize("width", [80, 72, 60])
def test_no_name_or_number_breaks_in_a_narrow_terminal(result, truth, width):
    coefficients = (
        coefficient(f"{LONG}.phong_exponent", 123.45678, 3e-5),
        coefficient(f"{LONG}.k_d.r", 0.25, 2e-7, at_bound=True),
        coefficient("b.k_d", 0.5000001, 6e-9),
    )
    result = dataclasses.replace(result, coefficients=coefficients, correlation=np.eye(3))
    console = Console(width=width, no_color=True, record=True, file=open(os.devnull, "w"))
    with console.file:
        console.print(coefficient_table(result, truth, width))
    text = console.export_text()
    assert max(map(len, text.splitlines())) <= width and "…" not in text
    words = text.split()
    assert {"b.k_d", "123.456780", "0.2500000", "0.000030"} <= set(words)
    assert LONG in text and ".phong_exponent" in text and ".k_d.r" in text
    assert truth is None or "123.4" in words


def test_a_table_with_room_keeps_every_name_on_its_line(result):
    console = Console(width=120, no_color=True, record=True, file=open(os.devnull, "w"))
    with console.file:
        console.print(coefficient_table(result, None, 120))
    text = console.export_text()
    assert "start" in text and "glass.phong_exponent " in text


def test_an_interval_below_the_last_digit_reads_as_its_half_width():
    assert interval_text(coefficient("a.k_d", 0.01, 5e-9)) == "± 1e-08"


def test_converged_is_said_once(result):
    done = dataclasses.replace(
        result, status="converged", message="converged in 3 steps; spare.k_d left as it is: no object", steps=3
    )
    text = " ".join(summary_lines(done))
    assert text.lower().count("converged") == 1 and "spare.k_d left as it is" in text
    assert Page(report_html(done, title="t")).words.lower().count("converged") == 1


def test_a_misfit_and_the_rounding_level_are_said(result):
    bad = dataclasses.replace(
        result, status="converged", message="converged in 3 steps; the residual is not noise: etc", misfit=True
    )
    assert "the residual is not noise" in " ".join(summary_lines(bad))
    assert "the residual is not noise" in Page(report_html(bad, title="t")).words
    exact = dataclasses.replace(result, noise=1e-8, at_rounding_level=True)
    for words in (" ".join(summary_lines(exact)), Page(report_html(exact, title="t")).words):
        assert "at rounding level" in words and "estimated from the residual" not in words


def test_summary(result):
    text = " ".join(summary_lines(result))
    for words in ("Not fully determined", "2 of the 5", "rank 3", "3 steps", "0.50 s", "2.00 s", "estimated"):
        assert words in text


def test_outputs(result, tmp_path):
    folder = tmp_path / "new" / "folder"
    two = dataclasses.replace(result, views=(view("a/b"), view("a b", 4, 5)))
    written = write_outputs(two, folder, title="t", save_scene=save_scene, metadata={"target": "x.exr"})
    pictures = ["render_a_b.exr", "residual_a_b.exr", "render_a_b_2.exr", "residual_a_b_2.exr"]
    names = ["result.json", "fitted.toml", *pictures, "report.html"]
    assert [path.name for path in written] == names and sorted(os.listdir(folder)) == sorted(names)
    assert json.loads((folder / "result.json").read_text())["metadata"] == {"target": "x.exr"}
    np.testing.assert_array_equal(read_image(folder / "residual_a_b_2.exr").pixels, two.views[1].residual)
    np.testing.assert_array_equal(read_image(folder / "render_a_b.exr").pixels, two.views[0].render)
    again = write_outputs(result, folder, title="t", save_scene=save_scene)
    assert [path.name for path in again][2:4] == ["render.exr", "residual.exr"]


def test_a_failing_write_leaves_the_folder_as_it_was(result, tmp_path, monkeypatch):
    def broken(scene, path):
        path.write_text("half")
        raise OSError(28, "No space left on device")

    (tmp_path / "fitted.toml").write_text("before")
    with pytest.raises(OutputError, match=r"fitted\.toml: no space left on device; check that the disk") as caught:
        write_outputs(result, tmp_path, title="t", save_scene=broken)
    assert "\n" not in str(caught.value) and isinstance(caught.value, OSError)
    assert sorted(os.listdir(tmp_path)) == ["fitted.toml", "unfinished"]
    assert (tmp_path / "fitted.toml").read_text() == "before"

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(_outputs, "report_html", interrupted)
        with pytest.raises(KeyboardInterrupt):
            write_outputs(result, tmp_path, title="t", save_scene=save_scene)
    # The numbers of a long fit are there, whatever the report met.
    assert sorted(os.listdir(tmp_path)) == ["fitted.toml", "unfinished"]
    assert json.loads((tmp_path / "unfinished" / "result.json").read_text())["status"] == result.status
    write_outputs(result, tmp_path, title="t", save_scene=save_scene)
    assert "unfinished" not in os.listdir(tmp_path) and "result.json" in os.listdir(tmp_path)


@pytest.mark.parametrize("killed_at", range(12))
def test_a_folder_with_a_result_is_of_one_fit_whenever_the_program_is_killed(result, tmp_path, monkeypatch, killed_at):
    """Killed before any of the steps that change the folder: with result.json in it, every file is of the same fit."""
    names = ["result.json", "fitted.toml", "render.exr", "residual.exr", "report.html"]
    write_outputs(result, tmp_path, title="first", save_scene=save_scene, metadata={"run": 1})
    first = {name: (tmp_path / name).read_bytes() for name in names}
    steps = 0

    def step(real):
        def killing(*arguments, **options):
            nonlocal steps
            if Path(arguments[0]).parent in (tmp_path, tmp_path / "unfinished"):
                steps += 1
                if steps > killed_at:
                    raise SystemExit
            return real(*arguments, **options)

        return killing

    with monkeypatch.context() as patched:
        patched.setattr(_outputs.os, "replace", step(os.replace))
        patched.setattr(Path, "unlink", step(Path.unlink))
        other = dataclasses.replace(result, views=(view("main", 4, 5),), scene="the scene of another fit")
        try:
            write_outputs(other, tmp_path, title="second", save_scene=save_scene, metadata={"run": 2})
        except SystemExit:
            pass
    now = {name: (tmp_path / name).read_bytes() for name in names if (tmp_path / name).exists()}
    if "result.json" in now:
        same = {name: now[name] == first[name] for name in names}
        assert len(set(same.values())) == 1, same


def test_a_folder_that_cannot_be_written_is_one_message(result, tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OutputError, match=f"cannot write {re.escape(str(folder))}: a file stands where .* --out"):
            write_outputs(result, folder, title="t", save_scene=save_scene)
    for name in ("result.json", "render.exr"):
        folder = tmp_path / name
        (folder / name).mkdir(parents=True)
        with pytest.raises(OutputError, match=re.escape(name)):
            write_outputs(result, folder, title="t", save_scene=save_scene)
        assert not [left for left in os.listdir(folder) if left.startswith(".")]
