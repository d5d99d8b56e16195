"""What a fit would know before its picture is taken: against scatter, algebra, and fits of such pictures."""

import json
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from test_shots import TRUE, seen, studio

import diffwhitted as dw
import fitting
from diffwhitted.image import dealt
from diffwhitted.records import changed
from fitting.command_line import main
from fitting.command_line._identify import noises
from fitting.planning._identify import question
from fitting.problem._views import View
from fitting.solving._solve import solve

NOISE = 0.02


def with_target(problem, picture):
    """The problem of another picture, with the programs of the first."""
    (view,) = problem.views
    film = dealt(jnp.asarray(picture, jnp.float32), view.passes, view.parts[0].plan.pass_pixels)
    parts = tuple(replace(part, target=some) for part, some in zip(view.parts, film, strict=True))
    return replace(problem, views=(View(parts, picture, view.weight, view.passes, view.step),))


def test_standard_errors_are_the_scatter_of_200_noisy_fits():
    """Their relative error is 1/sqrt(400) = 5 %; none of five is further off than 10 %, and so are the correlations."""
    scene, truth = studio(), np.asarray(list(TRUE.values()))
    foretold = fitting.identify(scene, list(TRUE), noise=NOISE, cameras="a")
    asked = question(scene, list(TRUE), NOISE, "a", (), None, 1, None, None)
    problem = asked.about(asked.scene, asked.targets).problem
    clean, random = seen(scene, ("left", "right", "top")), np.random.default_rng(0)
    found = [
        solve(with_target(problem, clean + NOISE * random.normal(size=clean.shape)), truth, max_steps=20).values
        for _ in range(200)
    ]
    for c, scatter in zip(foretold.coefficients, np.std(found, axis=0, ddof=1), strict=True):
        assert c.standard_error == pytest.approx(scatter, rel=0.1), c.name
    np.testing.assert_allclose(foretold.correlation, np.corrcoef(np.transpose(found)), atol=0.15)


def test_one_brightness_of_many_pixels():
    """An even wall under ambient light: each of n pixels and 3 channels shows k_a I_a, so the standard error is
    noise / (I_a sqrt(3 n)); with noise of light the variance is read^2 + gain k_a I_a."""
    scene = dw.Scene(
        objects=[dw.Plane("wall", (0, 0, 1), 0, "paint")],
        materials={"paint": dw.Material(k_a=0.3)},
        ambient=0.8,
        cameras={"main": dw.Camera((0, 0, 5), (0, 0, 0), 40, 16, 12)},
    )
    expected = 0.8 * np.sqrt(3 * 16 * 12)
    even = fitting.identify(scene, ["paint.k_a"], noise=0.01)
    assert even["paint.k_a"].standard_error == pytest.approx(0.01 / expected, rel=1e-4)
    assert even["paint.k_a"].interval_95 == pytest.approx((0.3 - 0.0196 / expected, 0.3 + 0.0196 / expected), rel=1e-4)
    assert (even.noise, even.pixels, even.views, even.rank) == (pytest.approx(0.01), 192, ("main",), 1)
    light = fitting.identify(scene, ["paint.k_a"], noise=(0.01, 0.002))
    deviation = np.sqrt(1e-4 + 0.002 * 0.24)
    assert light["paint.k_a"].standard_error == pytest.approx(deviation / expected, rel=1e-4)
    assert light.noise == pytest.approx(deviation, rel=1e-4)


def test_a_fit_of_such_pictures_says_the_same():
    """Two cameras, each with its own noise."""
    noise = {"a": 0.01, "b": 0.03}
    foretold = fitting.identify(studio(), list(TRUE), noise=noise, cameras=["a", "b"])
    random = np.random.default_rng(3)
    targets = [
        fitting.Target(
            (light := seen(studio(), ("left", "right", "top"), name)) + sigma * random.normal(size=light.shape),
            name,
            noise=sigma,
        )
        for name, sigma in noise.items()
    ]
    fitted = fitting.fit(studio(), targets, list(TRUE))
    for c in fitted.coefficients:
        assert foretold[c.name].standard_error == pytest.approx(c.standard_error, rel=0.03), c.name


def test_shots_are_the_pictures_and_have_their_noise():
    """Two shots alike tell as much as one with noise smaller by the root of 2."""
    shots = tuple(dw.Shot(name, "a", lights=("left",), noise=0.02) for name in ("one", "two"))
    both = fitting.identify(changed(studio(), shots=shots), ["paint.k_d"])
    alone = fitting.identify(changed(studio(), shots=shots[:1]), ["paint.k_d"], noise={"one": 0.02 / 2**0.5})
    assert both.views == ("one", "two")
    assert both["paint.k_d"].standard_error == pytest.approx(alone["paint.k_d"].standard_error, rel=1e-5)


def test_what_cannot_be_told_apart_or_seen():
    """The exposure of a picture and all weights of light; a floor that is masked."""
    scene = changed(studio(), shots=(dw.Shot("s", "a", noise=0.01),))
    found = fitting.identify(scene, [*TRUE, "shot.s.exposure"])
    assert not found.identifiable and found.rank == 4
    assert "shot.s.exposure" in found["paint.k_d"].confounded_with
    assert found["paint.k_d"].standard_error is None and found["paint.phong_exponent"].standard_error is not None
    floor = dw.Scene(
        objects=[*scene.objects, dw.Plane("ground", (0, 1, 0), -1, "floor")],
        materials={**scene.materials, "floor": dw.Material(k_d=0.5)},
        lights=scene.lights,
        cameras=scene.cameras,
        shots=scene.shots,
    )
    masked = fitting.identify(floor, ["floor.k_d", "paint.k_d"], only="ball")
    assert not masked["floor.k_d"].seen and masked["paint.k_d"].identifiable
    assert masked.pixels == fitting.only(floor, "a", "ball").sum()


@pytest.mark.parametrize(
    "change, words",
    [
        ({}, ["'a' has none", "standard deviation > 0"]),
        ({"noise": -1.0}, ["noise", "> 0"]),
        ({"noise": {"c": 1.0}}, ["no shot or camera 'c'", "a"]),
        ({"noise": 0.1, "cameras": "c"}, ["no camera 'c'", "a, b"]),
        ({"noise": 0.1, "free": ["paint.k_x"]}, ["paint.k_x"]),
        ({"noise": 0.1, "only": "bal"}, ["no object 'bal'"]),
    ],
)
def test_what_cannot_be_asked(change, words):
    given = {"free": ["paint.k_d"], "cameras": "a"} | change
    with pytest.raises(fitting.FitError) as caught:
        fitting.identify(studio(), **given)
    assert all(word in str(caught.value) for word in words)
    with pytest.raises(fitting.FitError, match="leave the camera out"):
        fitting.identify(changed(studio(), shots=(dw.Shot("s", "a"),)), ["paint.k_d"], noise=1.0, cameras="a")


def test_noise_of_the_command_line():
    assert noises([]) is None and noises(["0.01"]) == 0.01
    assert noises(["read=0.01,gain=2e-4"]) == (0.01, 2e-4) and noises(["gain=2e-4"]) == (0.0, 2e-4)
    assert noises(["left=0.01", "right=read=0.02"]) == {"left": 0.01, "right": (0.02, 0.0)}
    for wrong in (["much"], ["read=x"], ["0.1", "0.2"], ["0.1", "left=0.2"], ["read=1,grain=2"]):
        with pytest.raises(dw.InputError, match="--noise .*allowed is"):
            noises(wrong)


def test_the_command_line(place, capsys):
    command = ["identify", "scene.toml", "--free", "paint.k_d", "paint.phong_exponent", "--noise"]
    assert main([*command, "0.01"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "What a fit of one picture (main) would know if the values are those of the scene; 192 pixels" in said
    assert "The picture would determine all 2 coefficients" in said and "paint.k_d 0.5" in said
    assert main([*command, "read=0.01,gain=0.0001", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    scene = dw.load_scene("scene.toml")
    expected = fitting.identify(scene, ["paint.k_d", "paint.phong_exponent"], noise=(0.01, 0.0001))
    error = found["coefficients"]["paint.k_d"]["standard_error"]
    assert error == pytest.approx(expected["paint.k_d"].standard_error, rel=1e-5)
    assert main([*command, "100"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "The picture would not determine paint.k_d, paint.phong_exponent" in said and "--suggest light" in said
    assert main(command[:-1]) == 2
    assert "'main' has none" in capsys.readouterr().err
