"""What README and the guide tell a reader to run, runs: their Python blocks, and their shell lines of `diffwhitted`.

The examples are made small for it, with a target of the true scene: commands and code are those of the page.
"""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import typer

import diffwhitted
from fitting.command_line import app, main

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs" / "guide").glob("*.md"))]
LONG = ("animate", "derivative", "explain", "tradeoff")
"""Commands that compile for minutes: their own tests run them, and here their words are understood."""
OF_READERS = ("examples/photographs/scene.toml", "lamps/fitted.toml", "scene.toml")
"""Scenes of readers, and the photographs, which a notebook fits: their commands are understood here."""


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def commands() -> dict[str, list[str]]:
    """The arguments of each `diffwhitted` command on the pages, by the line as it stands there."""
    lines = [
        line
        for page in PAGES
        for block in blocks(page, "sh")
        for line in block.replace("\\\n", " ").splitlines()
        if line.startswith("diffwhitted ")
    ]
    words = {line: shlex.split(line, comments=True)[1:] for line in lines}
    return {line: found[: found.index(">")] if ">" in found else found for line, found in words.items()}


@pytest.fixture
def small(tmp_path, monkeypatch):
    """A folder with examples of 96x72 pixels to work in."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").mkdir()
    for path in (ROOT / "examples").glob("*.toml"):
        text = re.sub(r"^width = \d+$", "width = 96", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
        text = re.sub(r"^height = \d+$", "height = 72", text, flags=re.MULTILINE)
        (tmp_path / "examples" / path.name).write_text(text, encoding="utf-8")
    truth = diffwhitted.load_scene("examples/three_spheres_truth.toml")
    picture = np.asarray(diffwhitted.render(truth, truth.cameras["main"]))
    diffwhitted.write_image("examples/three_spheres_antialiased.exr", picture)
    return tmp_path


@pytest.mark.parametrize("words", commands().values(), ids=lambda words: words[0])
def test_a_command_is_understood(words, small):
    command = typer.main.get_command(app).commands[words[0]]
    command.make_context(words[0], words[1:])


RUN = [words for words in commands().values() if words[0] not in LONG and not set(words) & set(OF_READERS)]


@pytest.mark.slow
@pytest.mark.parametrize("words", RUN, ids=lambda words: words[0])
def test_a_command_runs(words, small, capsys):
    assert main(words) == 0, capsys.readouterr().err
    for option in ("-o", "--out"):
        if option in words:
            assert (small / words[words.index(option) + 1]).exists()


def test_readme_shows_every_command():
    assert {words[0] for words in commands().values()} == {
        "animate",
        "convert",
        "derivative",
        "explain",
        "fit",
        "identify",
        "parameters",
        "render",
        "scene",
        "schema",
        "tradeoff",
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    "code", [pytest.param(b, id=f"{page.stem}-{n}") for page in PAGES for n, b in enumerate(blocks(page, "python"))]
)
def test_a_block_of_python_runs(code, small, capsys):
    """And says the truth of k_s, which stands in a comment of it."""
    names = {}
    exec(compile(code, "block", "exec"), names)
    if "shown" in names:
        assert names["shown"].shape == (72, 96, 3) and {*np.unique(names["shown"])} == {0, 1}
        return
    if "between" in names:
        assert names["early"].radiosity.shape == names["between"].radiosity.shape == (names["between"].areas.size, 3)
        return
    assert names["result"].status == "converged"
    assert float(capsys.readouterr().out.split()[0]) == pytest.approx(0.2, abs=1e-3)
    if "slope" in names:
        assert names["image"].shape == (72, 96, 3) and float(names["slope"]) > 0


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    assert all(link.startswith("https://") or (page.parent / link).exists() for link in links), links
