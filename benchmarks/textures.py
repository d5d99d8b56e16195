"""Image textures: how true their means over a footprint are, and the fit of a map texel by texel."""

import numpy as np

import diffwhitted
import fitting

from ._figures import Figure
from ._fresh import in_fresh_process, run

DENSITIES = (0.5, 1, 2, 4, 8, 16, 32, 64)
"""Texels a pixel, along its side."""
VIEWS = {"from the front": 0.0, "obliquely": 1.3}
"""Angle between the camera and the normal of the wall, radians."""
WIDTH, HEIGHT, ANGLE_DEG, AWAY = 64, 48, 20.0, 5.0
SIDES = 16, 64
"""The fewest and the most points along the side of a pixel that are the truth."""
AT_MOST = 0.02
SIZE, TARGET = 64, (320, 240)


def measure() -> list[Figure]:
    return [*_means(), *_fit()]


def _means() -> list[Figure]:
    """White noise, the hardest of textures: root mean square errors, against that of points."""
    noise = np.random.default_rng(0).random((128, 128, 3))
    pixel = 2 * AWAY * np.tan(np.radians(ANGLE_DEG / 2)) / HEIGHT
    figures = []
    for view, angle in VIEWS.items():
        camera = diffwhitted.Camera(
            (0, AWAY * np.sin(angle), AWAY * np.cos(angle)), (0, 0, 0), ANGLE_DEG, WIDTH, HEIGHT
        )
        for density in DENSITIES:
            scene = _wall(noise, 128 * pixel / density)
            side = int(np.clip(4 * density, *SIDES))
            truth = np.asarray(diffwhitted.render(scene, camera, samples=side, footprint=0))
            found, points = (
                float(np.sqrt(np.mean((np.asarray(diffwhitted.render(scene, camera, footprint=trees)) - truth) ** 2)))
                for trees in (1, 0)
            )
            note = f"points {points:.3f}; {side}x{side} points as truth"
            figures.append(Figure(f"white noise {view}, {density:g} texels a pixel: RMSE", found, "", AT_MOST, note))
    return figures


def _wall(texels, size: float) -> diffwhitted.Scene:
    """A wall with a picture of so many metres, turned."""
    texture = diffwhitted.ImageTexture(
        texels, mapping="planar", edge_u=(0.8 * size, 0.6 * size, 0), edge_v=(-0.6 * size, 0.8 * size, 0)
    )
    return diffwhitted.Scene(
        objects=[diffwhitted.Plane("wall", (0, 0, 1), 0, "paint")],
        materials={"paint": diffwhitted.Material(k_a=1, k_d=0, k_h=0, k_a_texture="picture")},
        textures={"picture": texture},
        max_depth=1,
    )


def _fit() -> list[Figure]:
    found = in_fresh_process("textures", "fit")
    note = f"{found['seen']} of {SIZE**2} texels seen, {found['status']}, {found['steps']} steps"
    return [
        Figure(f"map of {SIZE}x{SIZE} from three views of 320x240, compile included", found["seconds"], "s", 20, note),
        Figure("RMSE of the texels that are seen, pictures without noise", found["rmse"], "", 1e-3),
        Figure("with noise 0.002: (error / standard error) RMS - 1, absolute", found["apart"], "", 0.05,
               f"RMSE {found['noisy']:.2g}"),
    ]  # fmt: skip


def _part(what: str) -> dict:
    """A fit of pictures without noise, and one of noisy ones."""
    del what
    random = np.random.default_rng(0)
    row, column = np.mgrid[:SIZE, :SIZE] / SIZE
    waves = np.stack([0.5 + 0.3 * np.sin(9 * column + 3 * row), 0.5 + 0.3 * np.cos(7 * row), 0.3 + 0.4 * column], -1)
    true = 0.8 * waves + 0.15 * random.random((SIZE, SIZE, 3))
    scene, start = _room(true), _room(np.full_like(true, 0.5))
    pictures = {name: np.asarray(diffwhitted.render(scene, camera)) for name, camera in scene.cameras.items()}
    exact = fitting.fit_texture(start, "map", pictures)
    noisy = {name: picture + 0.002 * random.normal(size=picture.shape) for name, picture in pictures.items()}
    second = fitting.fit_texture(start, "map", noisy)
    apart = (second.texels - true)[second.seen]
    return {
        "seconds": exact.seconds,
        "status": exact.status,
        "steps": exact.steps,
        "seen": int(exact.seen.sum()),
        "rmse": _rms((exact.texels - true)[exact.seen]),
        "noisy": _rms(apart),
        "apart": abs(_rms(apart / second.standard_errors[second.seen]) - 1),
    }


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _room(texels) -> diffwhitted.Scene:
    """A wall with the map, a ball in its light, a floor; three cameras."""
    places = {"left": (-1.6, 0.8, 2.6), "middle": (0, 0, 3.2), "right": (1.8, 0.5, 2.6)}
    return diffwhitted.Scene(
        objects=[
            diffwhitted.Polygon("wall", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], "paint"),
            diffwhitted.Sphere("ball", (0.2, -0.3, 0.6), 0.3, "steel"),
            diffwhitted.Plane("floor", (0, 1, 0), -1.2, "grey"),
        ],
        materials={
            "paint": diffwhitted.Material(k_d=0.9, k_a=0.05, k_h=0, k_d_texture="map"),
            "steel": diffwhitted.Material(k_d=0.2, k_h=0.3, k_a=0.1),
            "grey": diffwhitted.Material(k_d=0.4, k_a=0.1, k_h=0),
        },
        lights=[diffwhitted.PointLight((1, 2, 4), 1.0), diffwhitted.PointLight((-2, 1, 4), 0.5)],
        textures={
            "map": diffwhitted.ImageTexture(
                texels, mapping="planar", origin=(-1, -1, 0), edge_u=(2, 0, 0), edge_v=(0, 2, 0), wrap="clamp"
            )
        },
        cameras={name: diffwhitted.Camera(place, (0, 0, 0), 40, *TARGET) for name, place in places.items()},
    )


if __name__ == "__main__":
    run("textures", measure, _part)
