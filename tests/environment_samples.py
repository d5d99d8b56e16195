"""Maps of all that is around, what they do by sums over their texels, and small scenes in them."""

import numpy as np

import diffwhitted as dw


def directions_of(height: int, width: int) -> np.ndarray:
    """The middles of the texels of a map, (height, width, 3): the middle column looks along -z, the right to +x."""
    polar = (np.arange(height) + 0.5)[:, None] * np.pi / height
    azimuth = (np.arange(width) + 0.5) / width * 2 * np.pi - np.pi
    across = np.sin(polar)
    return np.stack([across * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -across * np.cos(azimuth)], axis=-1)


def smooth(height: int = 64) -> np.ndarray:
    """A map without edges: a bright side, a bright top, some waves."""
    x, y, z = np.moveaxis(directions_of(height, 2 * height), -1, 0)
    return np.stack([1 + 0.8 * x, 0.6 + 0.5 * y * y - 0.3 * x * z, np.exp(1.5 * (z + 0.4 * y) - 1)], axis=-1)


def weighted_mean(texels: np.ndarray, about: np.ndarray, exponent: float) -> np.ndarray:
    """(n + 1) / (2 pi) times the integral of L max(R.w, 0)^n, by the middles of texels: (3,)."""
    height, width, _ = texels.shape
    towards = directions_of(height, width)
    area = (np.pi / height) * (2 * np.pi / width) * np.sqrt(1 - towards[..., 1] ** 2)
    cosine = np.maximum(towards @ (about / np.linalg.norm(about)), 0)
    return (exponent + 1) / (2 * np.pi) * ((cosine**exponent * area)[..., None] * texels).sum(axis=(0, 1))


def around(count: int, seed: int = 0) -> np.ndarray:
    """Unit directions, (count, 3)."""
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def ball_in(background, precision="float64", size=(8, 6), **material) -> dw.Scene:
    """A ball that fills most of the picture, without lamps or ambient light."""
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint")],
        materials={"paint": dw.Material(**material)},
        ambient=0.0,
        background=background,
        cameras={"main": dw.Camera((0.5, 0.8, 4), (0, 0, 0), 30, *size)},
        max_depth=2,
        precision=precision,
    )


def picture(scene, **how) -> np.ndarray:
    return np.asarray(dw.render(scene, scene.cameras["main"], **how))
