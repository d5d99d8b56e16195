"""`diffwhitted convert`: scenes and fits, what it says, and what it refuses."""

import json

import pytest
from command_line_samples import SCENE
from result_samples import small_result

import diffwhitted
from fitting.command_line import main
from fitting.telling._fit_tables import fit_table


@pytest.fixture
def fit(tmp_path, monkeypatch):
    """A folder with a scene and a fit, which is the current one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "fit").mkdir()
    (tmp_path / "fit" / "result.json").write_text(json.dumps(small_result().to_json()))
    (tmp_path / "fit" / "fitted.toml").write_text(SCENE.replace("k_d = 0.5", "k_d = 0.25"))
    return tmp_path


def test_the_suffix_or_the_format_says_what_is_written(fit, capsys):
    for arguments, begins in (
        (["scene.toml", "a.pov"], "// Written by diffwhitted"),
        (["scene.toml", "a.XML"], "<?xml"),
        (["scene.toml", "a.txt", "--format", "povray"], "// Written by diffwhitted"),
        (["scene.toml", "b.txt", "--format", "MD"], "| material |"),
        (["scene.toml", "c.toml"], "[scene]"),
    ):
        assert main(["convert", *arguments]) == 0
        assert (fit / arguments[1]).read_text().startswith(begins)
    said = capsys.readouterr()
    assert said.out.splitlines()[0] == "wrote a.pov" and "wrote a.txt (POV-Ray)" in said.out
    assert all(line.startswith("note: ") for line in said.err.splitlines())


def test_a_fit_gives_its_scene_or_its_table(fit, capsys):
    assert main(["convert", "fit", "a.json"]) == 0 == main(["convert", "fit/result.json", "b.json"])
    assert (fit / "a.json").read_text() == (fit / "b.json").read_text()
    assert json.loads((fit / "a.json").read_text())["parameters"]["paint.k_d"]["value"] == 0.25
    assert main(["convert", "fit", "a.md"]) == 0
    lines = (fit / "a.md").read_text().splitlines()
    assert lines[0] == "| coefficient | value ± standard error | 95 % interval |"
    assert lines[2] == r'| \<b>&"glass".k_d | 0.1203 ± 0.0004 | 0.1195 to 0.1212 |'
    assert lines[4] == r"| glass.k_s\* | (0.41) | none |"
    assert r"- \* glass.k_s: cannot be told apart from glass.k_h and glass.k_a" in lines
    assert "correlations" in capsys.readouterr().err
    (fit / "fit" / "fitted.toml").unlink()
    assert main(["convert", "fit", "a.tex"]) == 0
    text = (fit / "a.tex").read_text()
    assert r"glass.k\_t* & $1.0000 \pm 0.0020$ & $0.9960$ to $1.0000$ \\" in text
    assert main(["convert", "fit", "a.pov"]) == 2
    assert "fitted.toml is not beside it" in capsys.readouterr().err


def test_one_end_of_an_interval_and_a_unit():
    number = {"value": 2.0, "standard_error": 1e-8, "interval_95": [1.5, None], "unit": "m"}
    text, _ = fit_table({"coefficients": {"object.a.radius": number}}, "LaTeX")
    assert r"object.a.radius & $2.0000000 \pm 1 \times 10^{-8}$ & m & $\ge 1.5000000$ \\" in text
    same = {"value": 2.0, "standard_error": 1e-9, "interval_95": [2.0 - 2e-9, 2.0 + 2e-9]}
    assert r"| 2.0000000 ± 1 × 10^-9 | ± 2 × 10^-9 |" in fit_table({"coefficients": {"a": same}}, "Markdown")[0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["scene.toml", "a.obj"], "'.obj' is no format; there is .toml (TOML), .pov (POV-Ray), .xml (Mitsuba)"),
        (["scene.toml", "a"], "without a suffix"),
        (["scene.toml", "a.x", "--format", "povary"], "Did you mean 'povray'?"),
        (["scene.toml", "./scene.toml"], "would be lost"),
        (["scene.toml", "scene.toml", "--format", "pov"], "would be lost"),
        (["fit", "fit/result.json"], "would be lost"),
        (["fit", "fit/fitted.toml"], "would be lost"),
        (["none.toml", "a.pov"], "no such file"),
        ([".", "a.pov"], "there is no result.json in this folder"),
        (["odd.json", "a.tex"], "no result of a fit"),
        (["none.json", "a.tex"], "cannot be read"),
        (["scene.toml", "no/a.pov"], "make the folder first"),
        (["a.md", "a.mtl"], "are written, not read"),
    ],
)
def test_what_convert_refuses(fit, capsys, arguments, said):
    (fit / "odd.json").write_text("[1, 2]")
    before = {path: path.read_bytes() for path in fit.rglob("*") if path.is_file()}
    assert main(["convert", *arguments]) == 2
    heard = capsys.readouterr()
    assert heard.out == "" and heard.err.startswith("error: ") and heard.err.count("\n") == 1
    assert said in heard.err
    assert {path: path.read_bytes() for path in fit.rglob("*") if path.is_file()} == before


def test_what_was_converted_to_toml_is_the_same_scene(fit):
    assert main(["convert", "scene.toml", "again.toml"]) == 0
    scenes = [diffwhitted.load_scene(name) for name in ("scene.toml", "again.toml")]
    assert diffwhitted.formats.scene_text(scenes[0]) == diffwhitted.formats.scene_text(scenes[1])
