"""A floor under lamps of every kind that does not shine alike to all sides, and what arrives there by hand."""

import numpy as np

import diffwhitted as dw

SPOT = dict(
    position=(-1.0, 2.0, 0.5), look_at=(-0.8, -1.0, 0.0), colour=(0.9, 0.7, 0.5), exponent=3.0, inner_cone_deg=12.0,
    cone_deg=24.0, attenuation=(0.2, 0.1, 0.05), clamped=False,
)  # fmt: skip
HARD = dict(position=(0.2, 2.5, 1.0), direction=(0.1, -2.0, -0.3), colour=(0.2, 0.3, 0.4), cone_deg=15.0)
WARN = dict(
    position=(1.2, 1.5, -0.2), direction=(-0.2, -1.0, 0.1), colour=(0.3, 0.6, 0.2), exponent=2.0,
    flaps_x=(-0.7, 0.45), flaps_z=(-0.6, 0.5), cone_deg=70.0,
)  # fmt: skip
AMBIENT = dict(sky=(0.3, 0.4, 0.6), ground=(0.2, 0.1, 0.05), up=(0.3, 1.0, -0.2))
FADE = (0.9, -0.05)
FLOOR = (0.02, 1.0, -0.03)
OFFSET = -1.0


def scene(footprint=0, lights=None, **settings) -> dw.Scene:
    """The floor alone, from above; no shadow falls on it."""
    lamps = [dw.SpotLight(**SPOT, name="spot"), dw.SpotLight(**HARD, name="hard"), dw.WarnLight(**WARN, name="barn")]
    stated = dict(ambient=dw.Hemisphere(**AMBIENT), distance_fade=FADE, max_depth=1, precision="float64") | settings
    return dw.Scene(
        objects=[dw.Plane("floor", FLOOR, OFFSET, "paint")],
        materials={"paint": dw.Material(k_a=0.5, k_d=(0.5, 0.6, 0.7), k_h=0)},
        lights=lamps if lights is None else lights,
        cameras={"main": dw.Camera((0, 4, 3), (0.1, -1, 0), 40, 16, 12)},
        background=dw.ConstantBackground((0.1, 0.2, 0.3)),
        footprint=footprint,
        **stated,
    )


def smooth(x):
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def arrives(lamp, points):
    """Colour that arrives and the unit directions to the lamp, for points (n, 3)."""
    position = np.asarray(lamp["position"])
    away = points - position
    distance = np.linalg.norm(away, axis=1)
    axis = unit(np.asarray(lamp["look_at"]) - position if "look_at" in lamp else np.asarray(lamp["direction"]))
    cosine = away @ axis / distance
    share = np.maximum(cosine, 0) ** lamp.get("exponent", 0)
    outer = np.cos(np.radians(lamp["cone_deg"]))
    if "inner_cone_deg" in lamp:
        share = share * smooth((cosine - outer) / (np.cos(np.radians(lamp["inner_cone_deg"])) - outer))
    else:
        share = share * (cosine > outer)
    if "attenuation" in lamp:
        share = share / (np.stack([distance**0, distance, distance**2], axis=1) @ lamp["attenuation"])
    for k, axis in enumerate("xyz"):
        low, high = lamp.get(f"flaps_{axis}", (-np.inf, np.inf))
        share = share * (away[:, k] >= low) * (away[:, k] <= high)
    return np.asarray(lamp["colour"]) * share[:, None], -away / distance[:, None]


def by_hand(there: dw.Scene, samples: int = 1):
    """The picture of the floor: (height, width, 3)."""
    camera = there.cameras["main"]
    rows, columns = np.mgrid[: camera.height * samples, : camera.width * samples] + 0.5
    rays = camera.rays(columns.ravel() / samples, rows.ravel() / samples)
    origin, ways = (np.asarray(v.stacked(), np.float64) for v in (rays.origin, rays.direction))
    size = np.linalg.norm(FLOOR)
    normal = np.asarray(FLOOR) / size
    distance = (OFFSET / size - origin @ normal) / (ways @ normal)
    points = origin + ways * distance[:, None]
    sky, ground, up = (np.asarray(AMBIENT[name]) for name in ("sky", "ground", "up"))
    height = 0.5 * (1 + normal @ unit(up))
    light = 0.5 * np.ones_like(points) * (sky * height + ground * (1 - height))
    for lamp in (SPOT, HARD, WARN):
        colour, towards = arrives(lamp, points)
        light += np.asarray([0.5, 0.6, 0.7]) * colour * np.maximum(towards @ normal, 0)[:, None]
    light = light * np.maximum(FADE[0] + FADE[1] * distance, 0)[:, None]
    picture = light.reshape(camera.height, samples, camera.width, samples, 3).mean(axis=(1, 3))
    return picture
