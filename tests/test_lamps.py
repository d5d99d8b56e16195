"""Lamps that are far from where the scene has them: highlights, shading, and a look all around."""

import numpy as np
import pytest

import diffwhitted as dw
import fitting

LAMPS = {"a": (-0.5, 0.7, 0.6), "b": (0.6, 0.3, 0.8)}


def studio(lamps, *, chrome=True, matte=True, kind=dw.DirectionalLight):
    """A chrome ball and a matte one, a lamp a shot."""
    objects = [dw.Sphere("chrome", (1.1, 0, 0), 1, "chrome")] * chrome
    objects += [dw.Sphere("matte", (-1.1, 0, 0), 1, "matte")] * matte
    return dw.Scene(
        objects=objects,
        materials={"chrome": dw.Material(k_s=0.6, k_h=0.8, phong_exponent=60), "matte": dw.Material(k_a=0.05, k_d=0.5)},
        lights=[kind(place, 0.8, name=name) for name, place in lamps.items()],
        ambient=(0.3, 0.3, 0.3),
        cameras={"main": dw.Camera((0, 0, 6), (0, 0, 0), 32, 32, 20)},
    )


def turned(direction, degrees):
    """Away, towards the horizon to the right of the camera."""
    direction = np.asarray(direction) / np.linalg.norm(direction)
    across = np.cross(direction, (0, 1, 0))
    across /= np.linalg.norm(across)
    return tuple(np.cos(np.radians(degrees)) * direction + np.sin(np.radians(degrees)) * across)


def apart(found, true):
    """Degrees between two vectors."""
    a, b = (np.asarray(v, np.float64) / np.linalg.norm(v) for v in (found, true))
    return np.degrees(np.arccos(np.clip(a @ b, -1, 1)))


def shots_of(scene):
    targets = []
    for light in scene.lights:
        alone = dw.Scene(
            objects=scene.objects, materials=scene.materials, lights=[light], ambient=scene.ambient,
            cameras=scene.cameras,
        )  # fmt: skip
        picture = np.asarray(dw.render(alone, alone.cameras["main"], footprint=1), np.float64)
        targets.append(fitting.Target(picture, "main", shot=dw.Shot(light.name, lights=(light.name,))))
    return targets


@pytest.mark.slow
@pytest.mark.parametrize("chrome, matte", [(True, True), (False, True)])
@pytest.mark.parametrize("degrees", [60, -75])
def test_directions_far_off_are_found(degrees, chrome, matte):
    """Two lamps, a shot each; only one of the balls may be there."""
    true = studio(LAMPS, chrome=chrome, matte=matte)
    start = studio({name: turned(way, degrees) for name, way in LAMPS.items()}, chrome=chrome, matte=matte)
    free = ["light.*.direction", *(["matte.k_d"] if matte else []), *(["chrome.k_h"] if chrome else [])]
    guess = {name: 0.3 for name in free[1:]}
    result = fitting.fit(start, shots_of(true), free, start=guess)
    for name, light in zip(LAMPS, result.scene.lights, strict=True):
        assert apart(light.direction, LAMPS[name]) < 0.5, (name, result.message)
    assert "from where the pictures have the lamp" in result.message


@pytest.mark.slow
def test_places_far_off_are_found():
    """Point lights, whose distance is right and whose direction from the balls is 60 degrees off."""
    places = {name: tuple(8 * np.asarray(way) / np.linalg.norm(way)) for name, way in LAMPS.items()}
    start = {name: tuple(8 * np.asarray(turned(way, 60))) for name, way in LAMPS.items()}
    free = ["light.*.position", "chrome.k_h"]
    result = fitting.fit(studio(start, kind=dw.PointLight), shots_of(studio(places, kind=dw.PointLight)), free)
    for name, light in zip(LAMPS, result.scene.lights, strict=True):
        assert apart(light.position, places[name]) < 0.5, (name, result.message)


def test_a_start_that_is_right_is_kept():
    scene = studio(LAMPS)
    result = fitting.fit(scene, shots_of(scene), ["light.*.direction"], start={})
    assert "from where" not in result.message
    for name, light in zip(LAMPS, result.scene.lights, strict=True):
        assert apart(light.direction, LAMPS[name]) < 0.5
