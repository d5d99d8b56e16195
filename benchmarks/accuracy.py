"""What accuracy costs in time: ways to antialias against each other and POV-Ray's, and a tree cut off by its
throughput.

Errors are RMS differences in linear RGB from 32 x 32 points a pixel.
"""

from functools import partial

import numpy as np

import diffwhitted
from diffwhitted.accuracy._reference import rmse
from references.scenes import nested_glass

from . import _povray
from ._figures import Figure
from ._fresh import run
from ._scene import CAMERA, POVRAY_FILE, TARGET_SIZE, three_spheres
from ._timing import ratio, taking_turns

THRESHOLDS = (0.3, 0.1, 0.03, 0.01)
POVRAY = {
    f"POV-Ray +A{threshold} +AM{method} +R3": (f"+A{threshold}", f"+AM{method}", "+R3", "-J")
    for method in (1, 2)
    for threshold in (0.3, 0.1, 0.03)
}
DEPTH, CUTOFF = 12, 1 / 512


def measure() -> list[Figure]:
    return [*_antialiasing(), *_cutoff(), *_bounding()]


def _antialiasing() -> list[Figure]:
    scene = three_spheres(TARGET_SIZE)
    camera = scene.cameras[CAMERA]
    truth = np.asarray(diffwhitted.render(scene, camera, samples=32))
    plans = {trees: diffwhitted.plan(scene, camera, footprint=trees) for trees in (0, 1, 2)}
    ways = {
        f"{n} x {n} points": partial(diffwhitted.render, scene, camera, samples=n, plan=plans[0]) for n in (1, 2, 3, 4)
    }
    ways |= {f"adaptive, {t}": partial(diffwhitted.render, scene, camera, antialias=t) for t in THRESHOLDS}
    ways |= {f"{n} x {n} filtered trees": partial(diffwhitted.render, scene, camera, plan=plans[n]) for n in (1, 2)}
    times = dict(zip(ways, taking_turns(list(ways.values())), strict=True))
    errors = {name: rmse(way(), truth) for name, way in ways.items()}
    figures = [Figure(f"{name}: RMSE", errors[name], "", None, str(times[name])) for name in ways]
    figures += _povray_figures(truth)
    as_true = [name for name in ways if "adaptive" in name and errors[name] <= errors["4 x 4 points"]]
    fixed = times["4 x 4 points"]
    best = min(as_true, key=lambda name: times[name].median, default=None)
    figures.append(
        Figure(
            "adaptive, to the error of 4 x 4 points / their time",
            None if best is None else ratio(times[best], fixed).median,
            "",
            0.4,
            best or "no threshold reaches it",
        )
    )
    figures.append(
        Figure(
            "one filtered tree / time of 4 x 4 points",
            ratio(times["1 x 1 filtered trees"], fixed).median,
            "",
            0.4,
            f"at {errors['1 x 1 filtered trees'] / errors['4 x 4 points']:.2g} of their error",
        )
    )
    return figures


def _povray_figures(truth) -> list[Figure]:
    if not _povray.available():
        return [Figure("POV-Ray's antialiasing", None, "", None, _povray.MISSING)]
    figures = []
    for name, options in POVRAY.items():
        runs = [_povray.trace(POVRAY_FILE, *TARGET_SIZE, options) for _ in range(3)]
        seconds = [r.seconds for r in runs]
        figures.append(
            Figure(
                f"{name}: RMSE",
                rmse(runs[0].pixels, truth),
                "",
                None,
                f"{min(seconds) * 1e3:.0f} ms min, {np.median(seconds) * 1e3:.0f} ms median of 3; two threads",
            )
        )
    return figures


def _cutoff() -> list[Figure]:
    scene = nested_glass()
    whole, part = (
        diffwhitted.render_with_bound(scene, scene.cameras[CAMERA], max_depth=DEPTH, cutoff=cutoff)
        for cutoff in (0, CUTOFF)
    )
    missing = whole.image - part.image
    return [
        Figure(
            f"nested glass, depth {DEPTH}, cutoff 1/512: rays / rays without cutoff",
            part.rays / whole.rays,
            "",
            0.25,
            f"{part.rays:,} of {whole.rays:,}",
        ),
        Figure(
            "the light that it leaves out, at most, in cutoffs",
            float(missing.max()) / CUTOFF,
            "",
            1.0,
            f"RMS {np.sqrt(np.square(missing).mean()) / CUTOFF:.2g}; certified bound {part.most / CUTOFF:.3g}",
        ),
    ]


def _bounding() -> list[Figure]:
    from diffwhitted.rendering._passes import traced_passes
    from diffwhitted.rendering._radiance_bound import most_beyond

    scene = three_spheres().with_cutoff(0.01)
    camera = scene.cameras[CAMERA]
    plan = diffwhitted.plan(scene, camera)
    beyond = most_beyond(scene, camera, plan)
    plain, bounded = taking_turns(
        [lambda: traced_passes(scene, camera, plan), lambda: traced_passes(scene, camera, plan, 1, beyond)]
    )
    return [
        Figure("picture with its bound / without", ratio(bounded, plain).median, "", 1.1, f"{bounded}; without {plain}")
    ]


if __name__ == "__main__":
    run("accuracy", measure)
