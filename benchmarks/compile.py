"""How long the first picture takes to compile, in a fresh process without a cache, and a second start of the command
line.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import jax

import diffwhitted
from diffwhitted.rendering._passes import lowered_pass
from diffwhitted.tree import likely_room, make_plan

from ._figures import Figure
from ._fresh import in_fresh_process, run
from ._scene import CAMERA, FOLDER, SCENE_FILE, three_spheres

TARGET, START_TARGET = 3.0, 5.0
RUNS = 3
DEPTHS = (5, 12)


def measure() -> list[Figure]:
    found = {
        depth: min((in_fresh_process("compile", depth) for _ in range(RUNS)), key=lambda f: f["seconds"])
        for depth in DEPTHS
    }
    shallow, deep = DEPTHS
    return [
        *[_compiled(depth, found[depth]) for depth in DEPTHS],
        Figure(
            f"compile at depth {deep} / depth {shallow}", found[deep]["seconds"] / found[shallow]["seconds"], "", 1.15
        ),
        *_command_line(),
    ]


def _compiled(depth: int, found: dict) -> Figure:
    return Figure(
        f"compile of render, depth {depth}",
        found["seconds"],
        "s",
        TARGET,
        f"shortest of {RUNS} processes; tracing {found['tracing']:.2f} s, XLA {found['xla']:.2f} s; "
        f"first call of render {found['first']:.2f} s",
    )


def _measured_here(depth: str) -> dict:
    """In this process, which must not have rendered anything yet."""
    scene = three_spheres()
    camera = scene.cameras[CAMERA]
    room = likely_room(camera)
    plan = make_plan(scene, camera, max_depth=int(depth), capacity=room)
    times = [time.perf_counter()]
    lowered = lowered_pass(scene, camera, plan)
    times.append(time.perf_counter())
    lowered.compile()
    times.append(time.perf_counter())
    jax.clear_caches()
    begun = time.perf_counter()
    jax.block_until_ready(diffwhitted.render(scene, camera, max_depth=int(depth)))
    first = time.perf_counter() - begun
    return {"tracing": times[1] - times[0], "xla": times[2] - times[1], "seconds": times[2] - times[0], "first": first}


def _command_line() -> list[Figure]:
    name = "second start of `diffwhitted render`, shell to image"
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.exr"
        command = [sys.executable, "-m", "fitting", "render", str(SCENE_FILE), "-o", str(picture)]
        environment = os.environ | {"XDG_CACHE_HOME": folder, "JAX_ENABLE_COMPILATION_CACHE": "true"}
        seconds = []
        for _ in range(1 + RUNS):
            begun = time.perf_counter()
            done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=FOLDER.parent)
            seconds.append(time.perf_counter() - begun)
            if done.returncode or not picture.exists():
                return [Figure(name, None, "s", START_TARGET, f"it failed: {done.stderr.strip()[-200:]}")]
            picture.unlink()
    return [Figure(name, min(seconds[1:]), "s", START_TARGET, f"first start {seconds[0]:.1f} s; 640x480, depth 5")]


if __name__ == "__main__":
    run("compile", measure, _measured_here)
