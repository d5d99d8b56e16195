"""The command line, as a person meets it: what it writes, what it says, and its exit codes."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest
from command_line_samples import ROOT, SCENE, SECOND_CAMERA, rendered

import diffwhitted
from diffwhitted.image import read_image
from fitting.command_line import main
from fitting.command_line._environment import set_up
from fitting.command_line._options import spread
from fitting.command_line._render import chosen_footprint


def run_alone(*arguments, **options):
    """The command line as a process of its own."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", "fitting", *arguments], capture_output=True, text=True, env=environment, **options
    )


# As a process.


def test_a_process_renders_a_scene_to_a_file(place):
    ended = run_alone("render", "scene.toml", "-o", "picture.exr")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.startswith("wrote picture.exr: 16 x 12 pixels, 192 rays in ")
    np.testing.assert_allclose(read_image("picture.exr").pixels, rendered("scene.toml"), atol=1e-6)


def test_a_process_ends_with_one_message_and_no_traceback(place):
    ended = run_alone("render", "scenes.toml", "-o", "picture.exr")
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr == "error: scenes.toml: there is no such file. Did you mean 'scene.toml'?\n"


def test_a_reader_that_goes_away_is_no_error(place):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "fitting", "schema"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment) as process:
        process.stdout.close()
        assert process.stderr.read() == b""


# render


def test_a_picture_for_eyes_is_filtered_unless_told_otherwise(place, capsys):
    """PNG: one filtered tree a pixel, with rays past outlines; EXR: points. Samples exclude a footprint."""
    assert chosen_footprint(None, 1, 0, for_eyes=True) == 1 and chosen_footprint(None, 1, 0, for_eyes=False) == 0
    assert chosen_footprint(None, 4, 1, for_eyes=True) == 0 and chosen_footprint(0, 1, 2, for_eyes=True) == 0
    assert chosen_footprint(None, 1, 2, for_eyes=False) == 2 and chosen_footprint(3, 1, 0, for_eyes=False) == 3
    assert main(["render", "scene.toml", "-o", "a.png", "--samples", "3", "--footprint", "2"]) == 2
    assert "--samples 3 with --footprint 2: allowed is one of the two" in capsys.readouterr().err


def test_the_derivative_of_a_coefficient(place, capsys):
    """Where no ray moves it is exact, so the difference of points agrees to the noise of the points; written as
    numbers and as a picture.
    """
    assert (
        main(
            [
                "derivative",
                "scene.toml",
                "--of",
                "paint.k_d",
                "-o",
                "slope.exr",
                "--width",
                "16",
                "--check",
                "--check-samples",
                "16",
            ]
        )
        == 0
    )
    said = capsys.readouterr().out
    assert float(re.search(r"cosine ([0-9.]+)", said)[1]) > 0.98
    assert np.abs(read_image("slope.exr").pixels).max() > 0
    assert main(["derivative", "scene.toml", "--of", "paint.k_x", "-o", "slope.exr"]) == 2
    assert "paint.k_x" in capsys.readouterr().err


def test_display_formats_and_what_they_lose(place, capsys):
    assert main(["render", "scene.toml", "-o", "a.png", "--exposure", "2", "--width", "8", "--footprint", "0"]) == 0
    said = capsys.readouterr()
    assert "wrote a.png: 8 x 6 pixels, 48 rays" in said.out
    clipped = (rendered_small := rendered_at(8, 6)).max(axis=2) * 4 > 1
    assert f"note: {clipped.sum()} of 48 pixels are brighter than the display's white" in said.err
    shown = read_image("a.png").pixels
    np.testing.assert_allclose(shown, np.clip(4 * rendered_small, 0, 1), atol=1e-4)


def rendered_at(width, height):
    scene = diffwhitted.load_scene("scene.toml")
    return np.asarray(diffwhitted.render(scene, scene.cameras["main"].resized(width, height)))


def test_samples_camera_and_precision(place, capsys):
    (place / "two.toml").write_text(SCENE + SECOND_CAMERA)
    assert main(["render", "two.toml", "-o", "a.exr", "--samples", "2", "--precision", "float64"]) == 0
    assert "768 rays" in capsys.readouterr().out
    np.testing.assert_allclose(read_image("a.exr").pixels, rendered("scene.toml", samples=2), atol=1e-5)
    assert main(["render", "two.toml", "-o", "b.exr", "--camera", "side", "--depth", "1"]) == 0
    assert read_image("b.exr").pixels.shape == (6, 8, 3)


# explain and schema


def test_ray_counts_agree_with_povray(place, capsys):
    printed = json.loads((ROOT / "tests/targets/three_spheres.json").read_text())["povray_ray_counts"]
    assert main(["explain", str(ROOT / "examples/three_spheres_truth.toml"), "--json", "--no-measure"]) == 0
    rays = json.loads(capsys.readouterr().out)["rays"]
    assert sum(rays["by_level"]) == sum(rays["by_kind"].values()) == rays["total"]
    assert len(rays["by_level"]) == printed["max_level"]
    # POV-Ray counts the rays past the depth too, before it drops them.
    assert rays["total"] + sum(rays["cut_off"].values()) == pytest.approx(printed["rays"], rel=1e-3)
    for kind, name in (("mirror", "reflected"), ("transmitted", "refracted"), ("total", "tir")):
        assert rays["by_kind"][kind] + rays["cut_off"][kind] == pytest.approx(printed[name], rel=1e-3)
    # It counts a shadow ray once more for each surface of glass on its way; without those it prints 113762.
    assert rays["shadow"] == pytest.approx(113762, rel=1e-3)


def test_explain_says_what_a_free_coefficient_costs(place, capsys):
    assert main(["explain", "scene.toml", "--no-measure", "--json"]) == 0
    before = json.loads(capsys.readouterr().out)
    assert main(["explain", "scene.toml", "--free", "paint.k_s", "--depth", "2", "--no-measure"]) == 0
    said = capsys.readouterr().out
    assert (before["rays"]["by_level"], before["rays"]["shadow"] > 0) == ([192], True)
    assert {e["name"]: e["on"] for e in before["effects"]}["reflection"] is False
    assert "paint.k_s is free in the fit" in " ".join(said.split())
    assert max(map(len, said.splitlines())) <= 80


def test_explain_measures_each_effect_that_is_on(place, capsys):
    (place / "plain.toml").write_text(
        SCENE.replace("[scene]", '[scene]\nshadows = "off"\nambient = [0, 0, 0]').replace("k_h = 0.3", "k_h = 0")
    )
    assert main(["explain", "plain.toml", "--json"]) == 0
    explained = json.loads(capsys.readouterr().out)
    cost = explained["cost"]
    assert (
        cost["seconds"] > 0
        and cost["seconds_compile"] > 0
        and set(cost["work"]) == {"overhead", "intersection", "shading"}
    )
    for effect in explained["effects"]:
        assert (effect["cost"] is not None) == effect["on"] == (effect["name"] == "diffuse")


def test_explain_draws_where_the_rays_are(place, capsys):
    assert main(["explain", "scene.toml", "--no-measure", "--maps", "maps.png"]) == 0
    assert diffwhitted.read_image(place / "maps.png").pixels.std() > 0.05
    assert main(["explain", "scene.toml", "--no-measure", "--maps", "maps.doc"]) == 2
    assert "'.doc'" in capsys.readouterr().err and not (place / "maps.doc").exists()


def test_schema(capsys):
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out) == diffwhitted.scene_schema()


def test_help_and_version(capsys):
    assert main([]) == main(["--help"]) == main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("Usage: diffwhitted")
    assert main(["fit", "--help"]) == 0
    help_text = " ".join(capsys.readouterr().out.split())
    assert '--free "*.k_d" glass.k_h' in help_text and "Wildcards in quotes" in help_text


def test_options_take_several_values():
    from typer.main import get_command

    from fitting.command_line import app

    parameters = get_command(app).commands["fit"].params
    given = ["scene.toml", "--free", "a.k_d", "b.k_d", "-o", "out", "--target", "x.exr", "--quiet", "--", "rest"]
    expected = [
        "scene.toml",
        "--free",
        "a.k_d",
        "--free",
        "b.k_d",
        "-o",
        "out",
        "--target",
        "x.exr",
        "--quiet",
        "--",
        "rest",
    ]
    assert spread(parameters, given) == expected
    assert spread(parameters, ["--free", "a.k_d", "scene.toml"]) == ["--free", "a.k_d", "scene.toml"]


def test_a_cache_that_cannot_be_written_is_not_used(place, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(place / "scene.toml"))
    before = jax.config.jax_compilation_cache_dir
    try:
        jax.config.update("jax_compilation_cache_dir", None)
        set_up()
        assert jax.config.jax_compilation_cache_dir is None
    finally:
        jax.config.update("jax_compilation_cache_dir", before)


SHOT = """
[[shot]]
name = "dim"
exposure = 0.5
black_level = 0.01
encoding = "gamma:2"
filter = "gaussian"
"""


def test_render_shows_what_a_shot_would(place, capsys):
    """Exposure, level, filter and encoding of the shot; and a filter alone."""
    Path("scene.toml").write_text(Path("scene.toml").read_text() + SHOT)
    size = ["--width", "8", "--samples", "3"]
    assert main(["render", "scene.toml", "-o", "plain.exr", "--filter", "gaussian", *size]) == 0
    assert main(["render", "scene.toml", "-o", "dim.exr", "--shot", "dim", *size]) == 0
    assert main(["render", "scene.toml", "-o", "dim.png", "--shot", "dim", *size]) == 0
    light = 0.5 * read_image("plain.exr").pixels + 0.01
    np.testing.assert_allclose(read_image("dim.exr").pixels, light, rtol=1e-5)
    np.testing.assert_allclose(read_image("dim.png", encoding="gamma:2").pixels, np.clip(light, 0, 1), atol=2e-4)
    scene = diffwhitted.load_scene("scene.toml")
    points = np.asarray(diffwhitted.render(scene, scene.cameras["main"].resized(8, None), samples=3))
    assert np.abs(read_image("plain.exr").pixels - points).max() > 1e-3
    capsys.readouterr()
    assert main(["render", "scene.toml", "-o", "a.exr", "--shot", "dmi"]) == 2
    assert "--shot dmi: there is no such shot; there is dim" in capsys.readouterr().err
    assert main(["render", "scene.toml", "-o", "a.exr", "--filter", "box", "--footprint", "1"]) == 2
    assert "allowed is one way to antialias" in capsys.readouterr().err
