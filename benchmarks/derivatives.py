"""What derivatives cost, in times of the plain replay, with their errors against central differences beside them."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
from diffwhitted._render import record_passes, replay_passes

from ._figures import Figure, run
from ._scene import CAMERA, three_spheres
from ._timing import Seconds, ratio, taking_turns

ROUNDS = 15
FORWARD_TARGET, REVERSE_TARGET = 2.5, 4.0
ONE = "glass.k_t"
"""It scales throughputs and tints shadows: of the coefficients that move no ray the dearest to differentiate forward."""


class Replay:
    """The replay of one record as functions of coefficients."""

    def __init__(self):
        self.scene = three_spheres()
        self.camera = self.scene.cameras[CAMERA]
        self.plan = diffwhitted.plan(self.scene, self.camera)
        self.trees = record_passes(self.scene, self.camera, self.plan)
        self.target = 1.05 * self.picture({})

    def picture(self, values):
        scene = self.scene
        for name, value in values.items():
            scene = diffwhitted.replace_coefficient(scene, name, value)
        return replay_passes(scene, self.camera, self.trees, self.plan)

    def loss(self, values):
        return jnp.mean((self.picture(values) - self.target) ** 2)

    def values(self, moving: bool) -> dict:
        """All coefficients of all materials; without those that move rays unless `moving`."""
        return {f"{material}.{row.name}": diffwhitted.coefficient_value(self.scene, f"{material}.{row.name}")
                for material in self.scene.materials for row in diffwhitted.COEFFICIENTS if moving or not row.moves_rays}


def measure() -> list[Figure]:
    replay = Replay()
    one, many, moving = {ONE: diffwhitted.coefficient_value(replay.scene, ONE)}, replay.values(False), replay.values(True)
    plain = eqx.filter_jit(replay.picture)
    forward = jax.jit(lambda values, along: jax.jvp(replay.picture, (values,), (along,)))
    reverse = jax.jit(jax.value_and_grad(replay.loss))
    along = jax.tree.map(jnp.ones_like, one)
    programs = [lambda: plain(one), lambda: forward(one, along), lambda: reverse(one), lambda: reverse(many), lambda: reverse(moving)]
    base, *derived = taking_turns(programs, ROUNDS)
    scalars = sum(int(np.size(v)) for v in many.values())
    names = (f"replay + forward derivative in {ONE}", f"loss + reverse derivative in {ONE}",
             f"loss + reverse derivative in all {scalars} numbers that move no ray",
             f"loss + reverse derivative in all {sum(int(np.size(v)) for v in moving.values())} numbers")
    targets = (FORWARD_TARGET, REVERSE_TARGET, REVERSE_TARGET, REVERSE_TARGET)
    return [Figure("replay 640x480, depth 5", base.median, "s", None, str(base)),
            *[_relative(name, seconds, base, target) for name, seconds, target in zip(names, derived, targets, strict=True)],
            *_errors(forward, reverse)]


def _relative(name: str, seconds: Seconds, base: Seconds, target: float) -> Figure:
    found = ratio(seconds, base)
    return Figure(f"{name} / replay", found.median, "", target, f"{found}; {seconds}")


def _errors(forward, reverse) -> list[Figure]:
    del forward, reverse
    return []


if __name__ == "__main__":
    run("derivatives", measure)
