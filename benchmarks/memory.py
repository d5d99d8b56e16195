"""Peak memory of whole programs, Python and libraries included, each in a fresh process."""

import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
import fitting

from ._figures import Figure
from ._fresh import in_fresh_process, peak_memory, run
from ._scene import CAMERA, UNKNOWNS, three_spheres

IMAGE_TARGET, FIT_TARGET = 1.0, 2.0
UNKNOWNS = (*UNKNOWNS, "mirror.k_a", "coloured.k_a", "floor.k_a", "floor.k_d")
"""26 numbers; 30 where k_a and k_d of the glass are linear RGB."""


def measure() -> list[Figure]:
    start, image = (in_fresh_process("memory", what) for what in ("imports", "image"))
    fit = in_fresh_process("memory", "fit")
    imports = f"{start['peak']:.2f} GiB of it are Python and libraries"
    return [
        Figure("peak memory of the image 640x480, depth 5", image["peak"], "GiB", IMAGE_TARGET, imports),
        Figure(
            "peak memory of a fit, 640x480, 30 numbers",
            fit["peak"],
            "GiB",
            FIT_TARGET,
            f"{fit['unknowns']} numbers, {fit['steps']} steps, {fit['status']}; {imports}",
        ),
    ]


def _used(what: str) -> dict:
    return {"imports": dict, "image": _image, "fit": _fit}[what]() | {"peak": peak_memory()}


def _image() -> dict:
    scene = three_spheres()
    jax.block_until_ready(diffwhitted.render(scene, scene.cameras[CAMERA]))
    return {}


def _fit() -> dict:
    scene = three_spheres()
    for name in ("glass.k_a", "glass.k_d"):
        scene = diffwhitted.replace_coefficient(scene, name, jnp.full(3, diffwhitted.coefficient_value(scene, name)))
    target = np.asarray(diffwhitted.render(scene, scene.cameras[CAMERA]))
    result = fitting.fit(scene, target, free=UNKNOWNS, start={"*.k_?": 0.5}, max_steps=4)
    return {"unknowns": len(result.coefficients), "steps": result.steps, "status": result.status}


if __name__ == "__main__":
    run("memory", measure, _used)
