"""Where one more lamp or camera would tell most: against places at random, and against algebra."""

import json
import tomllib

import jax
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.records import changed
from fitting.command_line import main
from fitting.planning._sphere import all_around, best_direction

FREE = ["paint.k_d", "paint.k_h", "paint.phong_exponent"]
NOISE = 0.01
COMPILED: list[str] = []


def scene(shots=(), lamps=((3, 4, 4),)):
    """A ball on a floor."""
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint"), dw.Plane("ground", (0, 1, 0), -1, "floor")],
        materials={"paint": dw.Material(k_d=0.5, k_h=0.3, phong_exponent=30), "floor": dw.Material(k_d=0.4)},
        lights=[dw.PointLight(place, 0.8, name=f"lamp{n}") for n, place in enumerate(lamps)],
        cameras={"main": dw.Camera((0, 1, 5), (0, 0, 0), 40, 32, 24)},
        shots=shots,
    )


def total(found) -> float:
    """The sum of the logarithms of the standard errors, those of the exponent in its own scale."""
    errors = [c.standard_error or np.inf for c in found.coefficients]
    return float(np.log(errors).sum())


def test_directions_are_even_and_the_search_finds_a_peak():
    around = all_around(40)
    np.testing.assert_allclose(np.linalg.norm(around, axis=1), 1, atol=1e-12)
    assert np.linalg.norm(around.mean(axis=0)) < 0.02
    nearest = np.sort(around @ around.T, axis=1)[:, -2]
    assert np.all(np.degrees(np.arccos(nearest)) > 20)
    peak, tried = np.asarray([0.6, -0.64, 0.48]), []
    found = best_direction(lambda d: float(d @ peak), around, tried.append)
    assert np.degrees(np.arccos(found @ peak)) < 1.5 and tried == list(range(1, len(tried) + 1)) and len(tried) < 100


@pytest.fixture(scope="module")
def more_light():
    return fitting.suggest(scene(), FREE, noise=NOISE)


def test_one_more_lamp_beats_the_best_of_20_at_random(more_light):
    """At the same distance from the same middle, above the floor."""
    assert more_light.added and more_light.name == "suggested" and more_light.what == "light"
    assert total(more_light.after) < total(more_light.before) and more_light.gain > 1.5
    middle, random, others = np.asarray([0.0, 0.2, 0.8]), np.random.default_rng(0), []
    distance = np.linalg.norm(np.asarray([3, 4, 4]) - middle)
    while len(others) < 20:
        way = random.normal(size=3)
        place = middle + distance * way / np.linalg.norm(way)
        if place[1] > -1:
            lamps = ((3, 4, 4), tuple(place))
            others.append(total(fitting.identify(scene(lamps=lamps), FREE, noise=NOISE)))
    assert total(more_light.after) < min(others)


def test_what_is_suggested_is_what_a_scene_with_it_says(more_light):
    """The standard errors after are those of the scene that is handed back; the text is its table."""
    again = fitting.identify(more_light.scene, FREE, noise=NOISE)
    for c in again.coefficients:
        assert more_light.after[c.name].standard_error == pytest.approx(c.standard_error, rel=1e-4)
    (lamp,) = tomllib.loads(more_light.toml)["light"]
    assert lamp["position"] == list(more_light.place) and lamp["name"] == "suggested" and lamp["type"] == "point"
    np.testing.assert_allclose(more_light.scene.lights[1].position, more_light.place, rtol=1e-6)


def test_places_compile_nothing(more_light):
    """Another number of places, and other lamps of the scene: no program more."""
    jax.monitoring.register_event_duration_secs_listener(
        lambda event, seconds, **about: COMPILED.append(event) if "backend_compile" in event else None
    )
    COMPILED.clear()
    other = fitting.suggest(scene(lamps=((-2, 5, 3),)), FREE, noise=NOISE, directions=12)
    assert not COMPILED and other.place != more_light.place


def test_a_lamp_of_its_own_shot_and_one_that_is_there():
    """The shots of the scene do not change; of a matte ball k_d alone is told best by a lamp near to the camera, whose
    side of the ball it lights.
    """
    shots = (dw.Shot("first", noise=NOISE),)
    found = fitting.suggest(scene(shots), ["paint.k_d"])
    assert [shot.name for shot in found.scene.shots] == ["first", "suggested"]
    assert found.scene.shots[0].lights == ("lamp0",) and found.scene.shots[1].lights == ("suggested",)
    tables = tomllib.loads(found.toml)
    assert tables["shot"][0]["lights"] == ["suggested"] and tables["shot"][0]["noise"] == NOISE
    to_camera, to_lamp = np.asarray([0, 1, 5.0]), np.asarray(found.place)
    cosine = to_camera @ to_lamp / np.linalg.norm(to_camera) / np.linalg.norm(to_lamp)
    assert np.degrees(np.arccos(cosine)) < 35
    alone = fitting.identify(found.scene, ["paint.k_d"])
    assert found.after["paint.k_d"].standard_error == pytest.approx(alone["paint.k_d"].standard_error, rel=1e-4)
    unknown = fitting.suggest(scene(shots), ["paint.k_d", "shot.first.exposure"], directions=12)
    assert (unknown.before.rank, unknown.after.rank) == (2, 2) and unknown.after.identifiable
    there = fitting.suggest(scene(lamps=((0, 5, -6),)), FREE, "light.lamp0", noise=NOISE)
    assert not there.added and len(there.scene.lights) == 1 and there.scene.shots == ()
    assert total(there.after) < total(there.before)


def test_one_more_camera_where_one_sees_too_little():
    """The first camera sees the left ball only: the rank is 1 of 2. The second sees the other, from outside of both."""
    before = scene()
    known = dw.Scene(
        objects=[*before.objects, dw.Sphere("right", (3, 0, 0), 1, "other")],
        materials={**before.materials, "other": dw.Material(k_d=0.3)},
        lights=before.lights,
        cameras={"main": dw.Camera((-2, 1, 5), (-2, 0, 0), 40, 32, 24)},
    )
    found = fitting.suggest(known, ["paint.k_d", "other.k_d"], "camera", noise=NOISE)
    assert (found.before.rank, found.after.rank) == (1, 2) and found.after.identifiable
    camera = found.scene.cameras["suggested"]
    assert not any(thing.holds(np.asarray(camera.look_from)) for thing in known.objects)
    assert (dw.layers(found.scene, camera).of("right")).any()
    assert tomllib.loads(found.toml)["camera"][0]["look_from"] == list(found.place)


@pytest.mark.parametrize(
    "what, free, words",
    [
        ("lamp", FREE, ["'lamp'", "allowed is 'light' or 'camera'"]),
        ("light.lamp1", FREE, ["no light 'lamp1'", "Did you mean 'lamp0'"]),
        ("light.lamp0", ["light.lamp0.position"], ["light.lamp0.position.x is free"]),
    ],
)
def test_what_cannot_be_put_elsewhere(what, free, words):
    with pytest.raises(fitting.FitError) as caught:
        fitting.suggest(scene(), free, what, noise=NOISE)
    assert all(word in str(caught.value) for word in words)


def test_the_command_line_prints_place_errors_and_table(place, capsys):
    (place / "ball.toml").write_text("")
    dw.save_scene(changed(scene()), place / "ball.toml")
    command = ["identify", "ball.toml", "--free", *FREE, "--noise", "0.01", "--suggest", "light"]
    assert main(command) == 0
    said = capsys.readouterr()
    assert said.err == "" and "One more lamp tells most at (" in said.out and "times smaller" in said.out
    assert "suggested" in tomllib.loads(said.out.partition("For the scene file:")[2])["light"][0]["name"]
    assert main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["gain"] > 1.5 and found["what"] == "light" and len(found["place"]) == 3
