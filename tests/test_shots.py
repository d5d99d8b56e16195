"""Shots: one camera under a lamp each, exposures, levels, cameras of one kind; and the table [[shot]]."""

import functools

import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.records import changed

TRUE = {"paint.k_a": 0.1, "paint.k_d": 0.5, "paint.k_h": 0.4, "paint.phong_exponent": 40.0}


@functools.cache
def studio(k_a=0.1, k_d=0.5, k_h=0.4, phong_exponent=40.0):
    """A ball under three lamps, seen by two cameras of one size."""
    lamps = {"left": (-4, 3, 4), "right": (4, 2, 5), "top": (0.5, 6, 3)}
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint")],
        materials={"paint": dw.Material(k_a=k_a, k_d=k_d, k_h=k_h, phong_exponent=phong_exponent)},
        lights=[dw.PointLight(place, 0.9, name=name) for name, place in lamps.items()],
        ambient=(0.3, 0.3, 0.3),
        cameras={"a": dw.Camera((0, 0, 4), (0, 0, 0), 40, 40, 30), "b": dw.Camera((1, 1, 4), (0, 0, 0), 40, 40, 30)},
    )


def seen(scene, lights, camera="a", footprint=0):
    """The picture by some of the lamps, rendered as a scene that has no others."""
    alone = changed(scene, lights=tuple(light for light in scene.lights if light.name in lights))
    return np.asarray(dw.render(alone, alone.cameras[camera], footprint=footprint), np.float64)


def start():
    return studio(0.3, 0.3, 0.1, 10.0)


def test_a_lamp_a_picture():
    """The usual laboratory: one camera, a lamp for each picture, one of them by two."""
    burning = [("left",), ("right",), ("left", "top")]
    targets = [
        fitting.Target(seen(studio(), names), "a", shot=dw.Shot(f"s{k}", lights=names))
        for k, names in enumerate(burning)
    ]
    result = fitting.fit(start(), targets, list(TRUE))
    assert result.status == "converged" and [view.camera for view in result.views] == ["s0", "s1", "s2"]
    for name, value in TRUE.items():
        assert result[name].value == pytest.approx(value, rel=1e-4), name
    assert result.scene.shots == ()


def test_exposure_white_balance_and_black_level_are_found():
    """Two pictures of a known ball: the second with another exposure in each channel, on a level of its own."""
    factor, level = np.array([0.37, 0.5, 1.4]), 0.02
    light = seen(studio(), ("left", "top"))
    targets = [
        fitting.Target(light, "a", shot=dw.Shot("plain", lights=("left", "top"))),
        fitting.Target(
            factor * light + level, "a", shot=dw.Shot("dim", lights=("left", "top"), exposure=(1.0, 1.0, 1.0))
        ),
    ]
    result = fitting.fit(start(), targets, [*TRUE, "shot.dim.exposure", "shot.dim.black_level"])
    assert result.status == "converged"
    for name, value in TRUE.items():
        assert result[name].value == pytest.approx(value, rel=1e-3), name
    for channel, value in zip("rgb", factor, strict=True):
        assert result[f"shot.dim.exposure.{channel}"].value == pytest.approx(value, rel=1e-3)
    assert result["shot.dim.black_level"].value == pytest.approx(level, abs=1e-5)
    assert float(result.scene.shots[1].black_level) == pytest.approx(level, abs=1e-5)


def test_what_only_shows_as_a_product_is_named():
    """One picture of unknown exposure: the exposure and every weight of light cannot be told apart."""
    result = fitting.fit(start(), {"a": 0.37 * seen(studio(), ("left", "right", "top"))}, [*TRUE, "shot.a.exposure"])
    assert result.status == "not_identifiable" and result.rank == 4
    assert "shot.a.exposure" in result["paint.k_d"].confounded_with


def lit(left, right):
    """The ball by two distant lamps."""
    lights = [dw.DirectionalLight(left, 0.9, name="left"), dw.DirectionalLight(right, 0.9, name="right")]
    return dw.Scene(
        objects=studio().objects, materials=studio().materials, cameras=studio().cameras, lights=lights, ambient=0.3
    )


def test_two_cameras_and_a_lamp_that_only_one_of_them_sees():
    """Directions of lamps are free: each shot depends on its own lamp alone."""
    scene = lit((-4, 3, 4), (4, 2, 5))
    targets = [
        fitting.Target(seen(scene, (lamp,), camera, 1), camera, shot=dw.Shot(lamp, lights=(lamp,)))
        for lamp, camera in (("left", "a"), ("right", "b"))
    ]
    result = fitting.fit(lit((-4, 2, 4), (4, 2, 4)), targets, ["paint.k_d", "light.*.direction"], footprint=1)
    assert result["paint.k_d"].value == pytest.approx(0.5, rel=5e-3)
    for fitted, true in zip(result.scene.lights, scene.lights, strict=True):
        mine, theirs = (np.asarray(v) / np.linalg.norm(v) for v in (fitted.direction, true.direction))
        assert np.degrees(np.arccos(min(mine @ theirs, 1))) < 0.3


def test_the_response_of_a_camera():
    """v = e L f(r) + b, then v^(1/gamma), against numpy; and its derivative against a difference."""
    shot = dw.Shot("s", exposure=2.0, black_level=0.1, vignetting=(-0.3, 0.1, 0.0), gamma=2.2)
    light = np.random.default_rng(0).uniform(0.01, 0.4, (3, 7)).astype(np.float32)
    across, down = np.linspace(-0.8, 0.8, 7, dtype=np.float32), np.full(7, 0.3, np.float32)
    square = across**2 + down**2
    expected = (2 * light * (1 - 0.3 * square + 0.1 * square**2) + 0.1) ** (1 / 2.2)
    np.testing.assert_allclose(np.asarray(shot.shown(light, across, down)), expected, rtol=1e-5)
    bent = dw.Shot("s", response=(0.2, -0.1, 0.3))
    expected = light + light * (1 - light) * (0.2 - 0.1 * light + 0.3 * light**2)
    np.testing.assert_allclose(np.asarray(bent.shown(light, across, down)), expected, rtol=1e-5)


def test_a_scene_file_with_shots_is_fitted(tmp_path):
    """Pictures beside the scene file; saved elsewhere, the fitted scene still finds them."""
    scene = changed(
        start(),
        shots=(
            dw.Shot("one", "a", str(tmp_path / "one.exr"), lights=("left",)),
            dw.Shot("two", "b", str(tmp_path / "two.exr"), exposure=0.5, noise=(0.001, 0.0)),
        ),
    )
    dw.write_image(tmp_path / "one.exr", seen(studio(), ("left",)))
    dw.write_image(tmp_path / "two.exr", 0.5 * seen(studio(), ("left", "right", "top"), "b"))
    dw.save_scene(scene, tmp_path / "scene.toml")
    assert 'picture = "one.exr"' in (tmp_path / "scene.toml").read_text()
    loaded = dw.load_scene(tmp_path / "scene.toml")
    assert loaded.shots[1].noise == (0.001, 0.0) and loaded.shots[0].lights == ("left",)
    with pytest.raises(fitting.FitError, match="some have a noise and some do not"):
        fitting.fit(loaded, free=list(TRUE))
    result = fitting.fit(
        changed(loaded, shots=(loaded.shots[0], changed(loaded.shots[1], noise=None))), free=list(TRUE)
    )
    for name, value in TRUE.items():
        assert result[name].value == pytest.approx(value, rel=2e-3), name
    (tmp_path / "out").mkdir()
    dw.save_scene(result.scene, tmp_path / "out" / "fitted.toml")
    assert 'picture = "../one.exr"' in (tmp_path / "out" / "fitted.toml").read_text()


def test_faults_of_shots_are_named():
    with pytest.raises(dw.SceneError, match="shot 's': there is no light 'lft'; there is left, right, top.*left"):
        changed(studio()).__class__(
            objects=studio().objects, materials=studio().materials, lights=studio().lights, cameras=studio().cameras,
            shots=[dw.Shot("s", lights=("lft",))],
        )  # fmt: skip
    with pytest.raises(dw.SceneError, match="exposure = 0; allowed is > 0"):
        dw.Shot("s", exposure=0)
    with pytest.raises(dw.SceneError, match="noise = .*allowed is a standard deviation"):
        dw.Shot("s", noise={"sigma": 1})
    with pytest.raises(dw.SceneError, match="noise = .*both >= 0"):
        dw.Shot("s", noise={"read": -1})
    with pytest.raises(fitting.FitError, match="the scene has no \\[\\[shot\\]\\]"):
        fitting.fit(studio(), free=["paint.k_d"])
