"""Fits back of 106 materials, a ball of each under two lamps and under a map: which numbers a picture tells.

`python -m benchmarks.materials`. The materials are those of `references/phong_materials.json`, many of them with
highlights far smaller than a pixel, which no picture of points shows.
"""

import functools
import json
import time
from collections import Counter

import numpy as np

import diffwhitted
import fitting

from ._figures import Figure
from ._fresh import in_fresh_process, run
from ._scene import FOLDER

SIZE, NOISE = 64, 0.002
START = {"k_a": (0.1, 0.1, 0.1), "k_d": (0.3, 0.3, 0.3), "k_h": (0.2, 0.2, 0.2), "phong_exponent": 30.0}
KINDS = {"under two lamps": ("k_a", "k_d", "k_h", "phong_exponent"), "under a map": ("k_d", "k_h", "phong_exponent")}
"""What is free. Under a map alone there is no ambient light."""
WRONG = 4.5
"""More standard errors than Gaussian noise makes in some 1600 numbers."""
MISSED = 0.07
"""Of 95 % intervals; 5 % are due."""


def measure() -> list[Figure]:
    figures = []
    for kind in KINDS:
        found = in_fresh_process("materials", kind)
        told, named = found["told"], found["named"]
        note = (
            f"{told} numbers told, {named} named as not to be known ({found['statuses']}); furthest "
            f"{found['furthest']:.1f} standard errors ({found['whose']})"
        )
        longest = f"at most {found['most']:.1f} s"
        figures += [
            Figure(f"106 materials {kind}: numbers wrong with confidence", found["wrong"], "", 0, note),
            Figure(f"{kind}: 95 % intervals that miss", 100 * found["missed"] / told, "%", 100 * MISSED),
            Figure(f"{kind}: a fit, compiled (median)", found["seconds"], "s", 0.3, longest),
        ]  # fmt: skip
    return figures


@functools.cache
def room() -> diffwhitted.EnvironmentBackground:
    scene = diffwhitted.load_scene(FOLDER.parent / "examples" / "room.toml")
    assert isinstance(scene.background, diffwhitted.EnvironmentBackground)
    return scene.background


def ball(kind: str, **material) -> diffwhitted.Scene:
    """A ball that fills most of the picture."""
    lamps = [
        diffwhitted.PointLight((3, 4, 5), (0.9, 0.9, 0.9), name="key"),
        diffwhitted.PointLight((-4, 1, 3), (0.5, 0.5, 0.5), name="fill"),
    ]
    light = {"lights": lamps, "ambient": 1.0} if kind == "under two lamps" else {"ambient": 0.0, "background": room()}
    return diffwhitted.Scene(
        objects=[diffwhitted.Sphere("ball", (0, 0, 0), 1, "paint")],
        materials={"paint": diffwhitted.Material(highlight="reflected", **material)},
        cameras={"main": diffwhitted.Camera((0, 0, 5), (0, 0, 0), 26, SIZE, SIZE)},
        max_depth=1,
        **light,
    )


def _part(kind: str) -> dict:
    """All fits of one kind."""
    stated = json.loads((FOLDER.parent / "references" / "phong_materials.json").read_text())["materials"]
    random, seconds, statuses = np.random.default_rng(0), [], Counter()
    away, named, missed = {}, 0, 0
    start = ball(kind, **START)
    for material in stated:
        name = material.pop("name")
        scene = ball(kind, **{key: material[key] for key in KINDS[kind]})
        picture = np.asarray(diffwhitted.render(scene, scene.cameras["main"]))
        target = fitting.Target(picture + NOISE * random.normal(size=picture.shape), "main")
        begun = time.perf_counter()
        result = fitting.fit(start, target, [f"paint.{key}" for key in KINDS[kind]])
        seconds.append(time.perf_counter() - begun)
        statuses[result.status] += 1
        for found in result.coefficients:
            truth = float(np.asarray(diffwhitted.parameter_value(scene, found.name)))
            if found.interval_95 is None or found.standard_error is None:
                named += 1
                continue
            low, high = found.interval_95
            missed += not low <= truth <= high
            away[f"{name}, {found.name}"] = (
                0.0 if low <= truth <= high else abs(found.value - truth) / found.standard_error
            )
    whose = max(away, key=away.__getitem__)
    return {
        "told": len(away),
        "named": named,
        "missed": missed,
        "wrong": sum(distance > WRONG for distance in away.values()),
        "furthest": away[whose],
        "whose": whose,
        "statuses": ", ".join(f"{count} {status}" for status, count in statuses.most_common()),
        "seconds": float(np.median(seconds[1:])),
        "most": max(seconds[1:]),
    }


if __name__ == "__main__":
    run("materials", measure, _part)
