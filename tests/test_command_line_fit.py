"""`diffwhitted fit`, as a person meets it: what it writes, what it says, and its exit codes."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line_samples import SCENE, SECOND_CAMERA, rendered

import diffwhitted
from diffwhitted.image import write_image
from fitting.command_line import main
from fitting.command_line._named_values import files_of_cameras, true_values
from fitting.command_line._targets import read_targets

RESULTS = {"result.json", "fitted.toml", "render.exr", "residual.exr", "report.html"}


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
    # A clipped code says that the light is no less: data with one side.
    assert kept == pytest.approx(1.6, rel=1e-3)


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
    main_view, side = read_targets(scene, ["main.exr", "side=side.exr"], ["side=half.exr"], None, "0.1", notes.append)
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
