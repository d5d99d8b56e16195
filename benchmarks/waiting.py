"""Waiting: pictures and gradients under `jit` without a plan, imports, and the second start of a command."""

import os
import subprocess
import sys
import tempfile
import time

import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted

from ._figures import Figure
from ._fresh import run
from ._scene import CAMERA, SCENE_FILE, three_spheres
from ._timing import ratio, taking_turns

ROUNDS = 10
WITHOUT_PLAN, GRADIENT_WITHOUT_PLAN = 1.5, 3.0
IMPORT = 0.5
NAME = "glass.k_t"
SIZES = ((160, 120), (640, 480))


def measure() -> list[Figure]:
    figures = [figure for size in SIZES for figure in _without_a_plan(size)]
    return [*figures, _import(), *_starts()]


def _without_a_plan(size: tuple[int, int]) -> list[Figure]:
    """Picture, and reverse derivative in one number, by programs that take turns; error and memory beside the times."""
    scene = three_spheres(size)
    camera, value = scene.cameras[CAMERA], diffwhitted.coefficient_value(scene, NAME)
    plans = diffwhitted.plan(scene, camera), None
    weights = jnp.asarray(np.random.default_rng(0).normal(size=(camera.height, camera.width, 3)), scene.dtype)

    def picture(value, plan):
        return diffwhitted.render(diffwhitted.replace_coefficient(scene, NAME, value), camera, plan=plan)

    def program(plan, differentiated: bool):
        def loss(value):
            return (weights * picture(value, plan)).sum()

        function = jax.grad(loss) if differentiated else lambda value: picture(value, plan)
        return jax.jit(function).lower(value).compile()

    figures = []
    for what, differentiated, target in (("picture", False, WITHOUT_PLAN), ("gradient", True, GRADIENT_WITHOUT_PLAN)):
        planned, free = (program(plan, differentiated) for plan in plans)
        error = float(jnp.max(jnp.abs(planned(value) - free(value))) / jnp.max(jnp.abs(planned(value))))
        base, seconds = taking_turns([lambda p=p: p(value) for p in (planned, free)], ROUNDS)
        memory = free.memory_analysis().temp_size_in_bytes / 2**20  # pyright: ignore[reportOptionalMemberAccess]
        note = f"{ratio(seconds, base)}; {seconds}; {memory:.0f} MiB; largest relative difference {error:.1g}"
        name = f"{what} {size[0]}x{size[1]} under jit without a plan / with one"
        figures.append(Figure(name, ratio(seconds, base).median, "", target, note))
    return figures


def _import() -> Figure:
    """Processor time of `import diffwhitted` where jax is there already."""
    clock = "time.process_time()"
    script = f"import time, jax, jax.numpy; begun = {clock}; import diffwhitted; print({clock} - begun)"
    seconds = [float(subprocess.check_output([sys.executable, "-c", script], text=True)) for _ in range(5)]
    return Figure("import diffwhitted, processor time beyond jax", min(seconds), "s", IMPORT, f"shortest of {seconds}")


def _starts() -> list[Figure]:
    """`diffwhitted render` with a footprint, twice, with a cache of its own: the second has other numbers and names."""
    with tempfile.TemporaryDirectory() as folder:
        text = SCENE_FILE.read_text(encoding="utf-8")
        seconds = []
        for number, scene in enumerate(
            (text, text.replace("0.9, 0.1, 0.1", "0.8, 0.2, 0.1").replace('"ball"', '"orb"'))
        ):
            path = os.path.join(folder, f"{number}.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(scene)
            environment = os.environ | {"XDG_CACHE_HOME": folder}
            for name in ("JAX_ENABLE_COMPILATION_CACHE", "JAX_COMPILATION_CACHE_DIR"):
                environment.pop(name, None)
            command = [sys.executable, "-m", "fitting", "render", path, "-o", f"{path}.exr", "--width", "64"]
            begun = time.perf_counter()
            subprocess.run([*command, "--height", "48", "--footprint", "1"], check=True, env=environment)
            seconds.append(time.perf_counter() - begun)
    first = Figure("render --footprint 1, first start, in all", seconds[0], "s")
    return [first, Figure("the same, second start, other numbers and names", seconds[1], "s")]


if __name__ == "__main__":
    run("waiting", measure)
