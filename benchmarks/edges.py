"""Derivatives through moving edges: how true they are, what a filtered tree costs, and the fit of an index.

Truth is the central difference of pictures of 64 x 64 points a pixel; it is itself uncertain by about 5 to 10 % in L2.
"""

import time
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
import fitting
from diffwhitted.accuracy._reference import rmse
from diffwhitted.rendering._passes import lowered_pass, record_passes, replay_passes
from diffwhitted.tree import likely_room, make_plan
from references.supersampled import INDEX, SCENES, area_true, changed, cosine, filtered, reference, relative, spheres

from ._figures import Figure
from ._fresh import in_fresh_process, run
from ._scene import CAMERA, three_spheres
from ._timing import ratio, taking_turns

SIDE, STEP = 64, 1e-3
TREES = {1: ("one tree", 0.98, 0.20, 0.006), 2: ("2x2 trees", 0.99, 0.13, 0.002)}
OTHERS = {1.1: (2e-4, 64), 1.33: (1e-3, 64), 1.8: (2e-4, 192), 2.4: (2e-3, 128)}
"""Other indices, with steps that follow the speed of the edges, and points along a pixel's side enough for such a
step.
"""
STARTS = (1.05, 1.1, 1.2, 1.33, 1.5, 1.8, 2.1, 2.4)


def measure() -> list[Figure]:
    return [*_truth(), *_other_indices(), *_cost(), *_compile(), *_fits(), *_joint_fit()]


def _truth() -> list[Figure]:
    figures = []
    for name, make in SCENES.items():
        scene = make()
        camera = scene.cameras["main"]
        image, slope = reference(lambda d: changed(scene, 1.5 + d, 0.0), camera, STEP, SIDE)  # noqa: B023
        away = image - area_true(changed(scene, 1.33, 0.0), camera, 16)
        for trees, limits in TREES.items():
            figures += _scores(f"{name}, {limits[0]}", filtered(scene, camera, trees=trees), image, slope, away, limits)
    return figures


def _scores(name: str, ours, image, slope, away, limits) -> list[Figure]:
    picture, derivative = ours
    pull = float((away * derivative).sum() / (away * slope).sum())
    return [
        Figure(
            f"{name}: 1 - cosine",
            1 - cosine(derivative, slope),
            "",
            1 - limits[1],
            f"gradient of a loss {pull:.3f} times the true one",
        ),
        Figure(f"{name}: relative L2 error", relative(derivative, slope), "", limits[2]),
        Figure(f"{name}: RMSE of the image", rmse(picture, image), "", limits[3]),
    ]


def _with_index(scene: diffwhitted.Scene, index: float, step: float) -> diffwhitted.Scene:
    return changed(scene, index + step, 0.0)


def _other_indices() -> list[Figure]:
    scene, figures = spheres(), []
    camera = scene.cameras["main"]
    cases = [
        (f"index {index}", index, step, partial(_with_index, scene, index), (1.0, 0.0), side)
        for index, (step, side) in OTHERS.items()
    ]
    cases.append(("sphere along x", 1.5, 5e-4, partial(changed, scene, 1.5), (0.0, 1.0), SIDE))
    for name, index, step, make, along, side in cases:
        _, slope = reference(make, camera, step, side)
        plain, ours = (filtered(scene, camera, index=index, along=along, refine=refine)[1] for refine in (False, True))
        figures.append(
            Figure(
                f"spheres, {name}, refined: relative L2 error",
                relative(ours, slope),
                "",
                0.18,
                f"cosine {cosine(ours, slope):.3f} (target 0.985); one tree {relative(plain, slope):.3f}, "
                f"{cosine(plain, slope):.3f}",
            )
        )
    return figures


def _cost() -> list[Figure]:
    """Times in turns; 640x480, the three spheres of the other benchmarks."""
    scene = three_spheres()
    camera = scene.cameras[CAMERA]
    plans = [diffwhitted.plan(scene, camera, footprint=trees) for trees in (0, 1)]
    plain, ours = taking_turns([lambda plan=plan: diffwhitted.render(scene, camera, plan=plan) for plan in plans])
    nodes = [
        camera.width * camera.height + int(np.sum(record_passes(scene, camera, plan).descendants)) for plan in plans
    ]
    trees = record_passes(scene, camera, plans[1])
    image = jax.jit(lambda v: replay_passes(diffwhitted.replace_coefficient(scene, INDEX, v), camera, trees, plans[1]))
    along = jax.jit(lambda v: jax.jvp(image, (v,), (jnp.ones_like(v),)))
    value = jnp.asarray(1.5, scene.dtype)
    alone, both = taking_turns([lambda: image(value), lambda: along(value)])
    return [
        Figure("filtered picture / plain picture", ratio(ours, plain).median, "", 3.0, f"{ours}; plain {plain}"),
        Figure("nodes of the filtered tree / plain", nodes[1] / nodes[0], "", 1.3, f"{nodes[1]} against {nodes[0]}"),
        Figure(
            "filtered replay with its derivative in the index / without",
            ratio(both, alone).median,
            "",
            3.0,
            f"{both}; without {alone}",
        ),
    ]


def _compile() -> list[Figure]:
    found = [in_fresh_process("edges", what) for what in ("picture", "derivative")]
    return [
        Figure(
            f"compile of a filtered {f['what']}, tracing included",
            f["seconds"],
            "s",
            limit,
            f"tracing {f['tracing']:.1f} s",
        )
        for f, limit in zip(found, (None, 8.0), strict=True)
    ]


def _measured_here(what: str) -> dict:
    scene = spheres()
    camera = scene.cameras["main"]
    plan = make_plan(scene, camera, capacity=likely_room(camera), footprint=1)
    begun = time.perf_counter()
    if what == "picture":
        lowered = lowered_pass(scene, camera, plan)
    else:
        image = lambda v: diffwhitted.render(diffwhitted.replace_coefficient(scene, INDEX, v), camera, plan=plan)  # noqa: E731
        lowered = jax.jit(lambda v: jax.jvp(image, (v,), (jnp.ones_like(v),))).lower(jnp.asarray(1.5, scene.dtype))
    traced = time.perf_counter()
    lowered.compile()
    return {"what": what, "tracing": traced - begun, "seconds": time.perf_counter() - begun}


def _fits() -> list[Figure]:
    scene = spheres()
    camera = scene.cameras["main"]
    worst, slowest = 0.0, 0.0
    for truth in (1.33, 1.5, 2.2):
        target = area_true(changed(scene, truth, 0.0), camera, 32).astype(np.float32)
        for start in STARTS:
            found = fitting.fit(scene, target, [INDEX], start={INDEX: start})
            worst, slowest = max(worst, abs(found[INDEX].value - truth)), max(slowest, found.seconds_solve)
    camera = camera.resized(80, 60)
    small = eqx.tree_at(lambda s: s.cameras, changed(scene, 1.5, 0.0), {"main": camera})
    clean, random = area_true(small, camera, 24), np.random.default_rng(5)
    found = [
        fitting.fit(small, (clean + random.normal(0, 0.02, clean.shape)).astype(np.float32), [INDEX])[INDEX]
        for _ in range(200)
    ]
    missed = 1 - float(
        np.mean([low <= 1.5 <= high for low, high in (f.interval_95 or (np.inf, -np.inf) for f in found)])
    )
    note = f"truth 1.33, 1.5, 2.2 from {', '.join(map(str, STARTS))}; 160x120"
    return [
        Figure(
            "intervals of an index that miss the truth, 200 noisy targets",
            100 * missed,
            "%",
            10.0,
            "2 to 10 % are expected of 95 % intervals",
        ),
        Figure("fit of an index, largest error", worst, "", 1e-3, note),
        Figure("fit of an index, slowest, after compiling", slowest, "s", 3.0, note),
    ]


def _joint_fit() -> list[Figure]:
    """Eleven coefficients at once, with one point light, all from elsewhere."""
    scene = spheres()
    camera = scene.cameras["main"]
    scene = eqx.tree_at(lambda s: s.lights, scene, scene.lights[:1])
    for name, value in {"floor.k_d": (0.8, 0.7, 0.6), "floor.k_a": 0.2, "blue.k_a": 0.1}.items():
        scene = diffwhitted.replace_coefficient(scene, name, np.asarray(value, np.float32))
    free = ["floor.k_d", "floor.k_a", "blue.k_d", "blue.k_a", "blue.phong_exponent", "glass.k_t", INDEX]
    start = {"floor.k_*": 0.5, "blue.k_*": 0.4, "blue.phong_exponent": 10.0, "glass.k_t": 0.6, INDEX: 1.8}
    found = fitting.fit(scene, area_true(scene, camera, 32).astype(np.float32), free, start=start)
    away = [abs(c.value - _true(scene, c.name)) for c in found.coefficients]
    shares = {c.name: off / (c.bounds[1] - c.bounds[0]) for c, off in zip(found.coefficients, away, strict=True)}
    worst = max(shares, key=lambda name: shares[name])
    errors = max(off / (c.standard_error or np.nan) for c, off in zip(found.coefficients, away, strict=True))
    return [
        Figure(
            "joint fit of 11, largest error in the width of its bounds",
            shares[worst],
            "",
            1e-3,
            f"{worst}; {found.status}; largest of the others "
            f"{max(share for name, share in shares.items() if not name.startswith('blue')):.1e} without "
            "the blue sphere",
        ),
        Figure("joint fit of 11, largest error in standard errors", errors, "", 3.0),
        Figure("joint fit of 11, after compiling", found.seconds_solve, "s", 10.0, f"{found.steps} steps, 160x120"),
    ]


def _true(scene, name: str) -> float:
    material, coefficient, *channel = name.split(".")
    values = np.asarray(diffwhitted.coefficient_value(scene, f"{material}.{coefficient}")).reshape(-1)
    return float(values["rgb".index(channel[0]) if channel else 0])


if __name__ == "__main__":
    run("edges", measure, _measured_here)
