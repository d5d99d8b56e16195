"""Light between surfaces: form factors of 2000 patches with visibility, the three ways to solve, and derivatives.

Rows are in seconds of the wall clock, and of both processors together where the name says so.
"""

import time

import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
from diffwhitted.interreflection import SOLVERS, solve
from diffwhitted.scene import patches_in

PATCHES = 2000


def seconds(call) -> tuple[float, float]:
    """Of the wall clock and of the processors, for a call whose programs are compiled."""
    start, busy = time.perf_counter(), time.process_time()
    jax.block_until_ready(call())
    return time.perf_counter() - start, time.process_time() - busy


def main() -> dict[str, float]:
    """Measure, and print a line for each row."""
    scene = diffwhitted.load_scene("examples/bleeding.toml")
    patches_in(scene, 300)  # compiles what all scenes share
    patches_in(scene, PATCHES - 100)
    rows = {}

    def note(name, call, repeat=1):
        wall, busy = min(seconds(call) for _ in range(repeat))
        rows[name], rows[f"{name}, processors"] = wall, busy
        print(f"{name}: {wall:.3g} s, {busy:.3g} s of processors", flush=True)

    note(f"form factors, about {PATCHES} patches", lambda: patches_in(scene, PATCHES)[1])
    factors, tables = patches_in(scene, PATCHES)
    count = len(tables.area)
    print(
        f"{count} patches, largest residual {factors.residual:.2g}, before rows were balanced {factors.imbalance:.2g}"
    )
    rho = jnp.asarray(np.random.default_rng(0).uniform(0.2, 0.7, (count, 3)), tables.area.dtype)
    sent = jnp.zeros_like(rho).at[tables.object == 5].set(1.0)
    for solver in SOLVERS:
        alone = jax.jit(lambda rho, solver=solver: solve(tables.matrix, tables.area, rho, sent, solver))
        forward = jax.jit(lambda rho, alone=alone: jax.jvp(alone, (rho,), (rho,)))
        back = jax.jit(jax.grad(lambda rho, alone=alone: (alone(rho) ** 2).sum()))
        for name, call in (("solve", alone), ("solve and jvp", forward), ("solve and gradient", back)):
            jax.block_until_ready(call(rho))
            note(f"{solver}: {name}", lambda call=call: call(rho), 3)
    return rows


if __name__ == "__main__":
    main()
