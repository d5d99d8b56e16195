"""What a fit does not look at: predicted as well as the rest where the model is right, worse where it is not."""

import json

import numpy as np
import pytest
from test_shots import TRUE, seen, start, studio

import diffwhitted as dw
import fitting
from diffwhitted.image import write_image
from fitting.command_line import main
from fitting.problem._holding_out import held_out
from fitting.problem._target import as_targets

LAMPS = ("left", "right")


def targets(**gains):
    return [
        fitting.Target(gains.get(lamp, 1.0) * seen(studio(), (lamp,)), "a", shot=dw.Shot(lamp, lights=(lamp,)))
        for lamp in LAMPS
    ]


def test_blocks_are_whole_and_always_the_same():
    picture = np.random.default_rng(0).uniform(size=(100, 150, 3))
    scene = dw.Scene(objects=[], materials={}, cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 40, 150, 100)})
    checked = as_targets(scene, picture)
    (left,), (out,), what = held_out(checked, 0.2)
    assert np.array_equal(out, held_out(checked, "20%")[1][0]) and what == "20 % of the pixels, in blocks"
    assert np.array_equal(left.mask, np.where(out, 0, 1)) and 0.15 < out.mean() < 0.25
    for row in range(0, 100, 16):
        for column in range(0, 150, 16):
            assert len(np.unique(out[row : row + 16, column : column + 16])) == 1


def test_a_shot_left_out_is_predicted_and_not_fitted():
    """The right model: to rounding. With a lamp that was really 1.5 times as bright: the shot left out is half of its
    light off, whatever the other says.
    """
    right = fitting.fit(start(), targets(), list(TRUE), hold_out="right")
    assert right.held_out is not None and right.held_out.rounding
    assert "the pixels left out are predicted as well as the others" in right.message
    assert right["paint.k_d"].value == pytest.approx(0.5, rel=1e-4)
    wrong = fitting.fit(start(), targets(right=1.5), list(TRUE), hold_out="right")
    assert wrong["paint.k_d"].value == pytest.approx(0.5, rel=1e-4)
    light = targets()[1].image
    assert wrong.held_out is not None and wrong.held_out.ratio > 1000
    assert wrong.held_out.rmse == pytest.approx(0.5 * float(np.sqrt(np.mean(light**2))), rel=1e-3)
    assert wrong.views[1].rmse == pytest.approx(wrong.held_out.rmse, rel=1e-5) and wrong.views[0].rmse < 1e-6
    assert "a thousand times or more worse" in wrong.message
    assert wrong.to_json()["held_out"]["what"] == "shot right"


def test_pixels_left_out_of_a_noisy_picture_are_as_noisy_as_the_others():
    noisy = targets()[0].image + 0.02 * np.random.default_rng(1).normal(size=(30, 40, 3))
    result = fitting.fit(
        start(), [fitting.Target(noisy, "a", shot=dw.Shot("left", lights=("left",)))], list(TRUE), hold_out=0.25
    )
    held = result.held_out
    assert held is not None and held.pixels == pytest.approx(300, abs=40)
    assert held.rmse == pytest.approx(0.02, rel=0.1) and held.rmse_fitted == pytest.approx(0.02, rel=0.1)
    assert "as well as the others" in held.sentence
    assert (result.views[0].weight == 0).sum() == held.pixels


def test_only_the_pixels_of_an_object_inside_its_outline():
    """A ball of which a floor is seen around: the mask is the ball's disc, a pixel smaller."""
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "a"), dw.Plane("wall", (0, 0, 1), -2, "b")],
        materials={"a": dw.Material(k_d=0.5), "b": dw.Material(k_d=0.4)},
        lights=[dw.PointLight((2, 3, 4), 1.0)],
        cameras={"main": dw.Camera((0, 0, 5), (0, 0, 0), 40, 40, 40)},
    )
    mask = fitting.only(scene, "main", "ball")
    radius = np.hypot(*np.meshgrid(np.arange(40) - 19.5, np.arange(40) - 19.5))
    edge = 20 / np.tan(np.radians(20)) / np.sqrt(24)
    assert np.all(mask[radius < edge - 1.5] == 1) and np.all(mask[radius > edge - 1] == 0)
    np.testing.assert_array_equal(fitting.only(scene, scene.cameras["main"], ["ball", "wall"]), np.ones((40, 40)))
    picture = np.asarray(dw.render(scene, scene.cameras["main"]), np.float64)
    picture[fitting.only(scene, "main", "wall") == 1] = 7.0
    result = fitting.fit(scene, fitting.Target(picture, mask=mask), ["a.k_d"], start={"a.k_d": 0.2})
    assert result["a.k_d"].value == pytest.approx(0.5, rel=1e-4)


@pytest.mark.parametrize(
    "hold_out, words",
    [
        ("lfet", ["no shot 'lfet'", "left, right", "Did you mean 'left'"]),
        ("120%", ["'120%'", "below 1"]),
        (0, ["hold_out = 0", "above 0"]),
        (["left", "right"], ["leaves no pixel to fit"]),
        (True, ["hold_out = True", "allowed is the name of a shot"]),
    ],
)
def test_what_cannot_be_left_out_is_refused(hold_out, words):
    with pytest.raises(fitting.FitError) as caught:
        fitting.fit(start(), targets(), list(TRUE), hold_out=hold_out)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize(
    "camera, names, words",
    [
        ("a", "bal", ["no object 'bal'", "Did you mean 'ball'"]),
        ("c", "ball", ["no camera 'c'", "a, b"]),
        (dw.Camera((0, 0, 4), (0, 0, 9), 40, 8, 6), "ball", ["sees no ball"]),
    ],
)
def test_only_what_is_there(camera, names, words):
    with pytest.raises(fitting.FitError) as caught:
        fitting.only(studio(), camera, names)
    assert all(word in str(caught.value) for word in words)


def test_the_command_line_leaves_out_and_masks(place, capsys):
    """The background of the target is wrong, which --only does not see."""
    scene = dw.load_scene("scene.toml")
    picture = np.asarray(dw.render(scene, scene.cameras["main"]))
    write_image("target.exr", np.where(dw.layers(scene, scene.cameras["main"]).of("ball")[..., None], picture, 0.9))
    command = ["fit", "start.toml", "--target", "target.exr", "--free", "paint.k_d", "paint.phong_exponent"]
    assert main([*command, "-o", "out", "--only", "ball", "--hold-out", "20%"]) == 0
    assert "the pixels left out are predicted as well as the others" in " ".join(capsys.readouterr().out.split())
    result = json.loads((place / "out/result.json").read_text())
    assert result["coefficients"]["paint.k_d"]["value"] == pytest.approx(0.5, rel=1e-4)
    assert result["held_out"]["pixels"] > 0 and "Left out" in (place / "out/report.html").read_text()
    assert main([*command, "-o", "out", "--only", "bal"]) == 2
    assert "no object 'bal'" in capsys.readouterr().err
