"""The result of a fit and what is written of it: JSON, page, terminal table, files."""

import dataclasses
import html
import json
import os
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from result_samples import ODD, TITLE, coefficient, small_result, view
from rich.console import Console

from fitting._held_out import HeldOut
from fitting._result import FitStage, FitView
from fitting.telling._lengths import seconds_text
from fitting.telling._report import report_html
from fitting.telling._tables import (
    coefficient_table,
    deviation_text,
    interval_text,
    places,
    rounded,
    rounded_error,
    summary_lines,
)


@pytest.fixture
def result():
    return small_result()


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
    with pytest.raises(ValueError, match="converged, misfit"):
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
        result, status="misfit", message="converged in 3 steps; spare.k_d left as it is: no object", steps=3
    )
    text = " ".join(summary_lines(done))
    assert text.lower().count("converged") == 1 and "spare.k_d left as it is" in text
    assert Page(report_html(done, title="t")).words.lower().count("converged") == 1


def test_a_misfit_and_the_rounding_level_are_said(result):
    bad = dataclasses.replace(
        result, status="misfit", message="at rest after 3 steps, but the model does not fit: etc", misfit=True
    )
    assert "the model does not fit" in " ".join(summary_lines(bad))
    assert "the model does not fit" in Page(report_html(bad, title="t")).words
    exact = dataclasses.replace(result, noise=1e-8, at_rounding_level=True)
    for words in (" ".join(summary_lines(exact)), Page(report_html(exact, title="t")).words):
        assert "at rounding level" in words and "estimated from the residual" not in words


def test_summary(result):
    text = " ".join(summary_lines(result))
    for words in ("Not fully determined", "2 of the 5", "rank 3", "3 steps", "0.50 s", "2.00 s", "estimated"):
        assert words in text


def test_several_shots_are_on_one_sheet(result):
    """Target, fit and residual of each, its numbers, and which was left out; the residuals on one scale."""
    loud = view("right")
    loud = dataclasses.replace(loud, residual=10 * loud.residual)
    held = HeldOut("shot right", 40, 0.1, 0.01, names=("right",))
    both = dataclasses.replace(result, views=(view("left"), loud), held_out=held)
    page = Page(report_html(both, title="t"))
    pictures = [attributes for tag, attributes in page.tags if tag == "img"]
    assert len(pictures) == 3 * 2 + 4 * 2 and "All shots" in page.words
    assert [p["alt"] for p in pictures[:3]] == ["Target of left", "Fit of left", "Residual of left"]
    rows = re.findall(r"(left|right)( left out of the fit)?\s+40\s+([0-9.]+)", page.words)
    assert [(name, bool(out)) for name, out, _ in rows] == [("left", False), ("right", True)]
    assert float(rows[1][2]) == pytest.approx(10 * float(rows[0][2]), rel=0.01)
    assert "All shots" not in Page(report_html(result, title="t")).words
    assert f"Of each: left {view('left').rmse:.3g}, right {loud.rmse:.3g}." in summary_lines(both)


def test_stages_of_one_name_are_told_as_one(result):
    stages = (FitStage("all", 10, 3, 1.0), FitStage("all", 10, 2, 0.5), FitStage("finer", 40, 1, 2.0))
    said = "\n".join(summary_lines(dataclasses.replace(result, stages=stages)))
    assert "all: 5 steps in 1.50 s; finer: 1 step in 2.00 s" in said
