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

import diffwhitted
from diffwhitted import CapacityError
from diffwhitted.image import read_image, write_image
from fitting.command_line import main
from fitting.command_line._environment import set_up
from fitting.command_line._failures import failed
from fitting.command_line._named_values import files_of_cameras, true_values
from fitting.command_line._options import spread
from fitting.command_line._render import chosen_footprint
from fitting.command_line._targets import read_targets

ROOT = Path(__file__).parent.parent
SCENE = """
[scene]
background = [0.2, 0.3, 0.4]

[[camera]]
look_from = [0, 0, 4]
look_at = [0, 0, 0]
vfov_deg = 40
width = 16
height = 12

[[light]]
type = "point"
position = [3, 5, 4]
colour = [0.9, 0.9, 0.9]

[[material]]
name = "paint"
k_a = 0.05
k_d = 0.5
k_h = 0.3
phong_exponent = 20

[[material]]
name = "hidden"
k_d = 0.5

[[object]]
name = "ball"
type = "sphere"
centre = [0, 0, 0]
radius = 1
material = "paint"

[[object]]
name = "behind the camera"
type = "sphere"
centre = [0, 0, 9]
radius = 1
material = "hidden"
"""
SECOND_CAMERA = """
[[camera]]
name = "side"
look_from = [4, 0, 0]
look_at = [0, 0, 0]
vfov_deg = 40
width = 8
height = 6
"""
RESULTS = {"result.json", "fitted.toml", "render.exr", "residual.exr", "report.html"}


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A cache folder for the module, so that a program is compiled once and the user's cache stays as it is."""
    yield tmp_path_factory.mktemp("cache")
    jax.config.update("jax_compilation_cache_dir", None)


@pytest.fixture
def place(tmp_path, monkeypatch, cache):
    """A folder with a scene, a start that is off, and a target, which is the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setenv("COLUMNS", "80")
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "start.toml").write_text(SCENE.replace("k_d = 0.5", "k_d = 0.2").replace("= 20", "= 60"))
    write_image("target.exr", rendered("scene.toml"))
    return tmp_path


def rendered(path, **options):
    scene = diffwhitted.load_scene(path)
    return np.asarray(diffwhitted.render(scene, scene.cameras["main"], **options))


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


# fit


def test_a_fit_that_converges(place, capsys):
    free = ["paint.k_d", "paint.k_h", "paint.phong_exponent"]
    assert (
        main(
            [
                "fit",
                "start.toml",
                "--target",
                "target.exr",
                "--free",
                *free,
                "--out",
                "out/of/it",
                "--truth",
                "scene.toml",
            ]
        )
        == 0
    )
    said = capsys.readouterr()
    assert said.err == ""
    assert "Converged." in said.out and "truth" in said.out and "Report: out/of/it/report.html" in said.out
    assert max(map(len, said.out.splitlines())) <= 80
    assert {path.name for path in (place / "out/of/it").iterdir()} == RESULTS
    assert "truth" in (place / "out/of/it/report.html").read_text()
    found = json.loads((place / "out/of/it/result.json").read_text())["coefficients"]
    assert [found[name]["value"] for name in free] == pytest.approx([0.5, 0.3, 20], rel=1e-5)
    np.testing.assert_allclose(rendered("out/of/it/fitted.toml"), rendered("scene.toml"), atol=1e-5)


def test_clipped_pixels_are_masked_and_said(place, capsys):
    """At four times the light a part of the ball is white in the file; the highlight lies there."""
    bright = SCENE.replace("k_d = 0.5", "k_d = 1.6")
    (place / "bright.toml").write_text(bright)
    pixels = rendered("bright.toml")
    assert 0.01 < (clipped := (pixels >= 1).any(axis=2)).mean() < 0.5
    write_image("bright.png", pixels)
    command = [
        "fit",
        "bright.toml",
        "--target",
        "bright.png",
        "--free",
        "paint.k_d",
        "--start",
        "paint.k_d=0.5",
        "--bounds",
        "paint.k_d=0:3",
    ]
    assert main([*command, "--out", "masked"]) == 0
    said = capsys.readouterr()
    assert f"note: bright.png: {clipped.sum()} of 192 pixels are clipped" in said.err and "--keep-clipped" in said.err
    main([*command, "--out", "kept", "--keep-clipped"])
    assert "clipped" not in capsys.readouterr().err
    masked, kept = (
        json.loads((place / out / "result.json").read_text())["coefficients"]["paint.k_d"]["value"]
        for out in ("masked", "kept")
    )
    assert masked == pytest.approx(1.6, rel=1e-3)
    assert kept < 1.55


@pytest.mark.parametrize("noise", ["-1", "0", "nan", "inf"])
def test_a_noise_that_is_none_is_refused_in_the_user_s_words(place, capsys, noise):
    assert (
        main(["fit", "start.toml", "--target", "target.exr", "--free", "paint.k_d", "--out", "out", "--noise", noise])
        == 2
    )
    assert f"--noise {noise}: allowed is a number > 0" in capsys.readouterr().err


def test_a_fit_that_cannot_know(place, capsys):
    arguments = [
        "fit",
        "start.toml",
        "--target",
        "target.exr",
        "--free",
        "hidden.k_d",
        "paint.k_d",
        "--out",
        "out",
        "--json",
    ]
    assert main([*arguments, "--start", "paint.k_d=0.9", "--bounds", "*.k_d=0:2", "--noise", "0.01", "--quiet"]) == 1
    said = capsys.readouterr()
    result = json.loads(said.out)
    assert result == json.loads((place / "out/result.json").read_text())
    assert (result["status"], said.err) == ("not_identifiable", "")
    hidden, paint = result["coefficients"]["hidden.k_d"], result["coefficients"]["paint.k_d"]
    assert (hidden["seen"], hidden["interval_95"], hidden["bounds"]) == (False, None, [0, 2])
    assert (paint["start"], result["noise_given"]) == (pytest.approx(0.9), True)


def test_a_second_stop_is_at_once(place, capsys, monkeypatch):
    def stopped(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("fitting.fit", stopped)
    assert main(["fit", "scene.toml", "--target", "target.exr", "--free", "*.k_d", "--out", "out"]) == 130
    assert capsys.readouterr() == ("", "stopped\n")
    assert not (place / "out").exists()


def test_targets_and_masks_by_camera(place):
    (place / "two.toml").write_text(SCENE + SECOND_CAMERA)
    scene, notes = diffwhitted.load_scene("two.toml"), []
    alpha = np.ones((12, 16))
    alpha[:3] = 0
    write_image("main.exr", np.full((12, 16, 3), 0.5), alpha=alpha)
    write_image("side.exr", np.full((6, 8, 3), 0.5))
    write_image("half.exr", np.full((6, 8, 3), 0.5))
    main_view, side = read_targets(scene, ["main.exr", "side=side.exr"], ["side=half.exr"], None, 0.1, notes.append)
    assert (main_view.camera, main_view.noise, side.camera) == ("main", 0.1, "side")
    np.testing.assert_array_equal(main_view.mask, alpha)
    np.testing.assert_array_equal(side.mask, 0.5)
    assert notes == ["main.exr: its alpha channel is the mask; 75% of the pixels count"]
    assert files_of_cameras("--target", ["a=b.exr"], {"main": 1, "a": 2}, "main") == {"a": Path("b.exr")}
    (place / "a=b.exr").touch()
    assert files_of_cameras("--target", ["a=b.exr"], {"main": 1}, "main") == {"main": Path("a=b.exr")}


def test_true_values_from_a_scene_and_from_json(place):
    from fitting.problem._unknowns import list_unknowns

    scene = diffwhitted.parse_scene(SCENE.replace("k_d = 0.5", "k_d = [0.1, 0.2, 0.3]", 1))
    diffwhitted.save_scene(scene, "coloured.toml")
    unknowns = list_unknowns(scene, ["paint.k_d", "paint.k_h"])
    expected = {"paint.k_d.r": 0.1, "paint.k_d.g": 0.2, "paint.k_d.b": 0.3}
    assert true_values(Path("coloured.toml"), scene, unknowns) == pytest.approx(expected | {"paint.k_h": 0.3})
    (place / "truth.json").write_text('{"paint.k_d": [0.1, 0.2, 0.3], "else.k_d": 1}')
    assert true_values(Path("truth.json"), scene, unknowns) == pytest.approx(expected)


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
    assert cost["seconds"] > 0 and cost["seconds_compile"] > 0 and sum(cost["work"].values()) == pytest.approx(1)
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


# What cannot be used: one message, and nothing written.

FIT = ["fit", "scene.toml", "--free", "paint.k_d", "--out", "out", "--target"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["render", "broken.toml", "-o", "a.png"], "broken.toml: broken TOML"),
        (["render", "scene.toml", "-o", "a.bmp"], "cannot write the extension '.bmp'"),
        (["render", "scene.toml", "-o", "none/a.png"], "does not exist"),
        (["render", "scene.toml", "-o", "a.exr", "--exposure", "1"], "exposure = 1.0 is for display"),
        (["render", "scene.toml", "-o", "a.png", "--camera", "mian"], "Did you mean 'main'?"),
        (["render", "scene.toml", "-o", "a.png", "--samples", "0"], "--samples"),
        (["render", "scene.toml"], "'--out'"),
        (["rendre", "scene.toml"], "Did you mean 'render'?"),
        ([*FIT, "none.exr"], "none.exr: no such file"),
        ([*FIT, "wide.exr"], "the picture has 20x12 pixels, the camera 16x12"),
        ([*FIT, "nan.exr"], "NaN"),
        ([*FIT, "side=target.exr"], "no camera 'side'; there is main"),
        ([*FIT, "target.exr", "target.exr"], "two files for camera 'main'"),
        ([*FIT, "target.exr", "--free", "glass.*"], "'glass.*' matches no coefficient"),
        ([*FIT, "target.exr", "--out", "broken.toml"], "a folder is needed"),
        ([*FIT, "target.exr", "--mask", "side=target.exr"], "no camera 'side'"),
        ([*FIT, "target.exr", "--start", "paint.k_d"], "allowed is NAME=VALUE"),
        ([*FIT, "target.exr", "--bounds", "paint.k_d=0.1"], "allowed is NAME=LOW:HIGH"),
        ([*FIT, "target.exr", "--start", "paint.k_d=much"], "'much' is not a number"),
        ([*FIT, "target.exr", "--truth", "other.json"], "holds none of the free coefficients"),
        (["explain", "scene.toml", "--free", "paint.kd"], "Did you mean 'paint.k_d'?"),
    ],
)
def test_what_cannot_be_used(place, capsys, arguments, said):
    (place / "broken.toml").write_text("[scene")
    (place / "other.json").write_text('{"a.k_d": 1}')
    write_image("wide.exr", np.zeros((12, 20, 3)))
    write_image("nan.exr", np.full((12, 16, 3), np.nan))
    before = set(place.iterdir())
    assert main(arguments) == 2
    heard = capsys.readouterr()
    assert heard.out == ""
    assert heard.err.startswith("error: ") and heard.err.count("\n") == 1
    assert said in heard.err
    assert set(place.iterdir()) == before


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (CapacityError("the ray tree needs more room"), 1, "more room"),
        (MemoryError(), 2, "not enough memory"),
        (RuntimeError("RESOURCE_EXHAUSTED: Out of memory allocating 9 bytes"), 2, "not enough memory"),
        (PermissionError(13, "x", "place/file"), 2, "place/file: permission denied"),
        (KeyError("a"), 1, "unexpected KeyError"),
    ],
)
def test_errors_and_their_exit_codes(capsys, error, code, said):
    assert failed(error) == code
    heard = capsys.readouterr().err
    assert heard.startswith("error: ") and heard.count("\n") == 1
    assert said in heard


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
    jax.config.update("jax_compilation_cache_dir", None)
    monkeypatch.setenv("XDG_CACHE_HOME", str(place / "scene.toml"))
    set_up()
    assert jax.config.jax_compilation_cache_dir is None
