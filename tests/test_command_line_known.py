"""What `diffwhitted fit` is told besides the pictures, as texts."""

import json

import pytest
from command_line_samples import SCENE

from diffwhitted import InputError
from fitting.command_line import main
from fitting.command_line._named_values import priors, starts, ties
from fitting.command_line._restrictions import Known


def test_the_texts_of_the_options():
    assert priors("--prior", ["a.k_d=1.5+-0.02", "b.k_d=1e-1±1e-3"]) == {"a.k_d": (1.5, 0.02), "b.k_d": (0.1, 0.001)}
    assert starts("--start", ["a.k_d=0.5,0.3,0.1", "b.k_d=[0.5, 0.3, 0.1]", "c.k_d=0.2"]) == {
        "a.k_d": (0.5, 0.3, 0.1),
        "b.k_d": (0.5, 0.3, 0.1),
        "c.k_d": 0.2,
    }
    assert ties("--tie", ["a=b", "c=0.5*d"]) == {"a": "b", "c": "0.5*d"}
    assert Known.read([], [], [], [], ["a.k_s+a.k_t=1"], ["a"]).options["at_most"] == {"a.k_s+a.k_t": 1.0}


@pytest.mark.parametrize(
    "read, text, words",
    [
        (priors, "a.k_d=1.5", "MEAN"),
        (priors, "a.k_d=x+-1", "'x' is not a number"),
        (starts, "a.k_d=0.1,x", "'x' is not a number"),
        (ties, "a", "NAME=OTHER"),
    ],
)
def test_texts_that_are_none(read, text, words):
    with pytest.raises(InputError, match=words):
        read("--option", [text])


def test_a_fit_is_told_all_of_it(place, capsys):
    options = ["--prior", "paint.phong_exponent=20+-5", "--tie", "paint.k_h=0.6*paint.k_d", "--loss", "huber"]
    free = ["--free", "paint.k_d", "paint.phong_exponent"]
    limit = ["--at-most", "paint.k_d+paint.k_a=1", "--free", "paint.k_a"]
    command = ["fit", "start.toml", "--target", "target.exr", *free, *limit, *options, "--out", "out", "-q"]
    assert main(command) in (0, 1), capsys.readouterr().err
    found = json.loads((place / "out" / "result.json").read_text())
    values = {name: c["value"] for name, c in found["coefficients"].items()}
    assert values["paint.k_h"] == pytest.approx(0.6 * values["paint.k_d"])
    assert found["coefficients"]["paint.phong_exponent"]["prior"]["standard_deviation"] == 5
    assert found["loss"] == "huber" and found["wild"] == []
    assert "k_d = 0.5" in SCENE
