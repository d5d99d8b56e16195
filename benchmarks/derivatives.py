"""What derivatives cost, in times of the plain replay, with their errors against central differences beside them."""

from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
from diffwhitted.accuracy._reference import rmse
from diffwhitted.rendering._passes import record_passes, replay_passes
from diffwhitted.scene import Row
from diffwhitted.tree import calls_for

from ._figures import Figure
from ._fresh import in_fresh_process, run
from ._scene import CAMERA, three_spheres
from ._timing import Seconds, ratio, taking_turns

ROUNDS = 15
FORWARD_TARGET, REVERSE_TARGET = 2.5, 4.0
ONE = "glass.k_t"
"""It scales throughputs and tints shadows: of the coefficients that move no ray the dearest to differentiate forward.
"""


class Replay:
    """The replay of one record as functions of coefficients."""

    def __init__(self, precision: Literal["float32", "float64"] = "float32", size: tuple[int, int] | None = None):
        self.scene = three_spheres(size, precision)
        self.camera = self.scene.cameras[CAMERA]
        self.plan = diffwhitted.plan(self.scene, self.camera)
        self.trees = record_passes(self.scene, self.camera, self.plan)
        self.target = 1.05 * self.picture({})
        self.compiled = jax.jit(self.picture)
        self.compiled_forward = jax.jit(lambda values, along: jax.jvp(self.picture, (values,), (along,)))

    def picture(self, values):
        scene = self.scene
        for name, value in values.items():
            scene = diffwhitted.replace_coefficient(scene, name, value)
        return replay_passes(scene, self.camera, self.trees, self.plan)

    def loss(self, values):
        return jnp.mean((self.picture(values) - self.target) ** 2)

    def along(self, name: str):
        """The picture and its derivative in one coefficient, all the channels of which move alike."""
        values = self.values(False)
        along = {n: jnp.ones_like(v) if n == name else jnp.zeros_like(v) for n, v in values.items()}
        return map(np.asarray, self.compiled_forward(values, along))

    def values(self, moving: bool) -> dict:
        """The coefficients that are at work, of all materials; without those that move rays unless `moving`."""
        names = [
            f"{material}.{row.name}"
            for material in self.scene.materials
            for row in diffwhitted.COEFFICIENTS
            if calls_for(self.scene, material, _needed(row)) and (moving or not row.moves_rays)
        ]
        return {name: diffwhitted.coefficient_value(self.scene, name) for name in names}


def _needed(row: Row) -> str:
    """The coefficient without which this one does nothing."""
    return {"phong_exponent": "k_h", "refractive_index": "k_t"}.get(row.name, row.name)


def measure() -> list[Figure]:
    replay = Replay()
    one, many, moving = (
        {ONE: diffwhitted.coefficient_value(replay.scene, ONE)},
        replay.values(False),
        replay.values(True),
    )
    plain, forward = replay.compiled, replay.compiled_forward
    reverse = jax.jit(jax.value_and_grad(replay.loss))
    along = jax.tree.map(jnp.ones_like, one)
    programs = [
        lambda: plain(one),
        lambda: forward(one, along),
        lambda: reverse(one),
        lambda: reverse(many),
        lambda: reverse(moving),
    ]
    base, *derived = taking_turns(programs, ROUNDS)
    scalars = sum(int(np.size(v)) for v in many.values())
    names = (
        f"replay + forward derivative in {ONE}",
        f"loss + reverse derivative in {ONE}",
        f"loss + reverse derivative in all {scalars} numbers that move no ray",
        f"loss + reverse derivative in all {sum(int(np.size(v)) for v in moving.values())} numbers",
    )
    targets = (FORWARD_TARGET, REVERSE_TARGET, REVERSE_TARGET, REVERSE_TARGET)
    return [
        Figure("replay 640x480, depth 5", base.median, "s", None, str(base)),
        *[
            _relative(name, seconds, base, target)
            for name, seconds, target in zip(names, derived, targets, strict=True)
        ],
        *_errors(),
    ]


def _relative(name: str, seconds: Seconds, base: Seconds, target: float) -> Figure:
    found = ratio(seconds, base)
    return Figure(f"{name} / replay", found.median, "", target, f"{found}; {seconds}")


def _errors() -> list[Figure]:
    found = in_fresh_process("derivatives", "errors")
    return [
        Figure(
            "forward derivative against central difference",
            found["forward"],
            "",
            1e-4,
            f"root mean square over that of the derivative, in float32; worst of {found['count']} coefficients "
            f"({found['worst']}); {found['forward64']:.1g} in float64",
        ),
        Figure(
            "reverse derivative against forward",
            found["reverse"],
            "",
            1e-4,
            "of the loss, largest error over largest derivative, in float32",
        ),
    ]


def _errors_here(_: str) -> dict:
    """In a process of its own, as 64-bit numbers are switched on for the differences."""
    jax.config.update("jax_enable_x64", True)
    single, double = Replay("float32", (160, 120)), Replay("float64", (160, 120))
    values = single.values(False)
    errors = {name: _forward_errors(single, double, name) for name in values}
    worst = max(errors, key=lambda name: errors[name][0])
    reverse = jax.jit(jax.grad(single.loss))(values)
    forward = jax.jit(jax.jacfwd(single.loss))(values)
    flat = [np.concatenate([np.ravel(v) for v in jax.tree.leaves(d)]) for d in (reverse, forward)]
    return {
        "forward": errors[worst][0],
        "forward64": max(e[1] for e in errors.values()),
        "worst": worst,
        "count": len(errors),
        "reverse": float(np.abs(flat[0] - flat[1]).max() / np.abs(flat[1]).max()),
    }


def _forward_errors(single: "Replay", double: "Replay", name: str) -> tuple[float, float]:
    """Of the picture's derivative in all channels of one coefficient together, in both precisions.

    Left out are pixels on the very edge of something, where rounding decides which of two surfaces or tiles is seen.
    """
    values = double.values(False)
    step = 1e-5 * float(jnp.max(values[name]))
    above, below = (np.asarray(double.compiled(values | {name: values[name] + s})) for s in (step, -step))
    difference = (above - below) / (2 * step)

    def error(replay: Replay) -> float:
        picture, derivative = replay.along(name)
        same = np.abs(picture - (above + below) / 2).max(axis=2) < 1e-3
        return rmse(derivative[same], difference[same]) / rmse(difference, 0)

    return error(single), error(double)


if __name__ == "__main__":
    run("derivatives", measure, _errors_here)
