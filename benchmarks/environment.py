"""Environments: how near their light on surfaces is to sums over the map, its cost, and a gloss in an unknown room."""

import time
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
import fitting
from diffwhitted.numerics._vector import vec3

from ._figures import Figure
from ._fresh import in_fresh_process, run

EXPONENTS = (1, 3, 10, 30, 100, 300, 1000)
ROWS, PLACES = 256, 400
K_D, K_H, EXPONENT, NOISE, SIZE = (0.3, 0.25, 0.2), (0.4, 0.3, 0.5), 6.0, 1e-4, 32


def measure() -> list[Figure]:
    found = in_fresh_process("environment", "fit")
    return [*_near(), *_cost(), *_fit(found)]


def _near() -> list[Figure]:
    """The hardest map, a lamp of one texel, and a smooth one: largest errors in shares of the largest value."""
    towards = _directions(ROWS)
    lamp, smooth = np.zeros((ROWS, 2 * ROWS, 3)), np.exp(towards @ np.asarray([[1, 0, 2], [1, 2, -1], [-1, 0, 0.5]]))
    lamp[70, 300] = 1000
    away = np.random.default_rng(0).normal(size=(PLACES, 3)) * np.geomspace(1e-3, 3, PLACES)[:, None]
    about = towards[70, 300] + away
    about /= np.linalg.norm(about, axis=1, keepdims=True)
    figures = []
    for name, texels, most in (("a lamp of one texel", lamp, 0.04), ("a smooth map", smooth, 0.005)):
        lit = diffwhitted.EnvironmentBackground(texels).surroundings(np.ones(1, bool))
        assert lit is not None
        truth = _means(texels, about, 1)
        worst = {
            "irradiance": np.abs(np.asarray(lit.mean(vec3(jnp.asarray(about))).stacked()) - truth).max() / truth.max()
        }
        for exponent in EXPONENTS:
            truth = _means(texels, about, exponent)
            light = lit.lobe(vec3(jnp.asarray(about)), jnp.full(PLACES, float(exponent))).stacked()
            worst[f"n = {exponent}"] = np.abs(np.asarray(light) - truth).max() / truth.max()
        note = ", ".join(f"{what} {100 * error:.2g} %" for what, error in worst.items())
        figures.append(
            Figure(f"light of {name} of {2 * ROWS}x{ROWS}: largest error", max(worst.values()), "", most, note)
        )
    return figures


def _directions(rows: int) -> np.ndarray:
    polar = (np.arange(rows) + 0.5)[:, None] * np.pi / rows
    azimuth = (np.arange(2 * rows) + 0.5) * np.pi / rows - np.pi
    across = np.sin(polar)
    return np.stack([across * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -across * np.cos(azimuth)], axis=-1)


def _means(texels: np.ndarray, about: np.ndarray, exponent: float) -> np.ndarray:
    """(n + 1) / (2 pi) times the integral of L max(R.w, 0)^n by the middles of the texels."""
    towards = _directions(len(texels))
    area = np.sqrt(1 - towards[..., 1] ** 2) * np.pi**2 / len(texels) ** 2
    weigh = partial(np.einsum, "rc,rck->k", optimize=True)
    return np.stack(
        [weigh((exponent + 1) / (2 * np.pi) * np.maximum(towards @ d, 0) ** exponent * area, texels) for d in about]
    )


def _cost() -> list[Figure]:
    """The light of a map of 1024 x 512 texels, once for each map."""
    texels = np.random.default_rng(0).random((512, 1024, 3)).astype(np.float32)
    start = time.perf_counter()
    jax.block_until_ready(diffwhitted.EnvironmentBackground(texels).surroundings(np.zeros(1, bool)))
    matte = time.perf_counter() - start
    start = time.perf_counter()
    jax.block_until_ready(diffwhitted.EnvironmentBackground(texels).surroundings(np.ones(1, bool)))
    glossy = time.perf_counter() - start
    name = "light of a map of 1024x512, once for each map, with highlights"
    return [Figure(name, glossy, "s", 3, f"without highlights {matte:.2f} s")]


def _fit(found: dict) -> list[Figure]:
    note = f"noise {NOISE:g}, {found['seconds']:.1f} s with compiling, {found['steps']} steps"
    return [
        Figure("glossy ball in an unknown room: k_h / k_d, largest relative error", found["ratio"], "", 0.01, note),
        Figure("its exponent, relative error", found["exponent"], "", 0.05, f"standard error {found['error']:.2g}"),
        Figure(
            "its unknowns less the rank: 3, a scale a channel", found["free"] - found["rank"], "", 3, found["status"]
        ),
        Figure("matte ball, 16 harmonics: unknown", found["unknown"], "", 21, "7 of degree 3 in three channels"),
    ]


def room(harmonics, **material) -> diffwhitted.Scene:
    """A ball in a room of harmonics."""
    return diffwhitted.Scene(
        objects=[diffwhitted.Sphere("ball", (0, 0, 0), 1, "paint")],
        materials={"paint": diffwhitted.Material(**material)},
        ambient=0.0,
        background=diffwhitted.HarmonicBackground(harmonics),
        cameras={"main": diffwhitted.Camera((0, 0, 4), (0, 0, 0), 30, SIZE, SIZE)},
        max_depth=1,
    )


def _part(what: str) -> dict:
    """A glossy ball before a masked background, nine coloured harmonics free; a matte one with sixteen."""
    del what
    random, begin = np.random.default_rng(4), time.perf_counter()
    true_room = np.concatenate([[[4, 3.6, 4.4]], 0.8 * random.normal(size=(8, 3))])
    true = room(true_room, k_d=K_D, k_h=K_H, phong_exponent=EXPONENT)
    start = room(2 * np.eye(9)[0][:, None] * [1, 1, 1], k_d=(0.5,) * 3, k_h=(0.5,) * 3, phong_exponent=30.0)
    picture = np.asarray(diffwhitted.render(true, true.cameras["main"]))
    picture = picture + NOISE * random.normal(size=picture.shape)
    target = fitting.Target(picture, "main", mask=fitting.only(true, "main", "ball"), noise=NOISE)
    free = ["background.harmonics", "paint.k_d", "paint.k_h", "paint.phong_exponent"]
    found = fitting.fit(start, target, free)
    ratios = [
        found[f"paint.k_h.{c}"].value / found[f"paint.k_d.{c}"].value * k_d / k_h - 1
        for c, k_d, k_h in zip("rgb", K_D, K_H, strict=True)
    ]
    gloss = found["paint.phong_exponent"]
    matte = room(np.concatenate([true_room, 0.5 * np.ones((7, 3))]), k_d=0.5, k_h=0.0)
    known = fitting.identify(matte, ["background.harmonics"], noise=0.01, only="ball")
    return {
        "ratio": float(np.abs(ratios).max()),
        "exponent": abs(gloss.value / EXPONENT - 1),
        "error": gloss.standard_error,
        "free": len(found.coefficients),
        "rank": found.rank,
        "status": found.status,
        "steps": found.steps,
        "seconds": time.perf_counter() - begin,
        "unknown": sum(not c.identifiable for c in known.coefficients),
    }


if __name__ == "__main__":
    run("environment", measure, _part)
