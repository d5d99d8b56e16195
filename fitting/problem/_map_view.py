"""Pictures as functions of the texels of one texture: along recorded trees, whose rays no texel moves.

Forward, many directions at a time, and backward; the Jacobian is never written down here.
"""

from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from diffwhitted.image import dealt, gathered
from diffwhitted.numerics._workers import side_by_side
from diffwhitted.records import changed
from diffwhitted.scene import AbstractCamera, Marks, Scene, Shot, from_middle, marks_of, near, tabulate
from diffwhitted.tree import Plan, Record, Samples, grid, likely_room, make_plan, record, replay

from ._target import CheckedTarget

PART_PIXELS = 20_000
"""A pass; with many directions at a time, larger ones outgrow the cache."""


class MapPart(eqx.Module):
    """One pass of a picture, with its trees."""

    scene: Scene
    camera: AbstractCamera
    shot: Shot
    samples: Samples
    trees: Any
    """The recorded trees; None before they are."""
    marks: Marks
    plan: Plan = eqx.field(static=True)
    texture: str = eqx.field(static=True)

    def shown(self, texels: Float[Array, "height width 3"], forward: bool = True) -> Float[Array, "3 pixels"]:
        """What the shot shows of the light."""
        light = replay(self.tables(texels), self.camera, self.trees, self.plan, self.samples, forward=forward)
        places = from_middle(self.samples.column, self.samples.row, *self.plan.picture)
        return self.shot.shown(light.stacked(axis=0), *places)

    def tables(self, texels):
        textures = self.scene.textures
        new = changed(textures[self.texture], texels=texels)
        return tabulate(changed(self.scene, textures={**textures, self.texture: new}), self.marks)


class MapView:
    """A target, the weights of its pixels, and its parts."""

    def __init__(self, scene: Scene, texture: str, target: CheckedTarget, footprint: int, max_depth: int | None):
        shot = target.shot
        lights = tuple(light for light in scene.lights if shot.burns(light.name))
        # Names are static in a program, and no part of this one.
        bare = changed(scene, lights=lights, shots=(), cameras={})
        bare, camera = near(bare, scene.cameras[target.camera])
        plan = make_plan(bare, camera, max_depth=max_depth, capacity=likely_room(camera, PART_PIXELS),
                         footprint=footprint, pass_of=PART_PIXELS)  # fmt: skip
        # One tree serves whatever the texels become: every branch of it is followed.
        plan = replace(plan, zero_weights=False)
        self.size = camera.height, camera.width
        noise = 1.0 if target.noise is None else target.noise.deviation(target.image)
        self.weight = np.broadcast_to(np.sqrt(target.mask)[..., None] / noise, target.image.shape)
        self.target = np.asarray(target.image, np.float64)
        self.name = target.name
        marks = marks_of(bare, plan.at_work, outlines=plan.footprint > 0)
        middle = jnp.full(2, 0.5, bare.dtype)
        plain = changed(shot, name="", camera=None, picture=None, mask=None, encoding=None, noise=None, filter=None,
                        lights=None)  # fmt: skip
        cast = jax.tree.map(lambda a: jnp.asarray(a, bare.dtype), plain)
        self.parts = [
            MapPart(bare, camera, cast, grid(plan, camera, jnp.asarray(n), middle), None, marks, plan.program, texture)
            for n in range(plan.passes)
        ]

    def recorded(self, texels) -> "MapView":
        """With the trees at these texels, and room for them."""
        while True:
            trees = side_by_side(lambda part: _trees(part, texels), self.parts)
            needed = max(int(tree.descendants.max()) for tree in trees)
            if needed <= self.parts[0].plan.capacity:
                break
            self.parts = [replace(part, plan=part.plan.with_capacity(2 * needed)) for part in self.parts]
        self.parts = [replace(part, trees=tree) for part, tree in zip(self.parts, trees, strict=True)]
        return self

    def picture(self, texels) -> Float[np.ndarray, "rows columns 3"]:
        return self._whole(side_by_side(lambda part: _look(part, texels), self.parts))

    def compile_along(self, texels, count: int) -> None:
        """The program of `along` for so many directions at a time."""
        jax.block_until_ready(_along(self.parts[0], texels, np.zeros((count, *texels.shape), texels.dtype)))

    def along(self, texels, ways: Float[np.ndarray, "ways height width 3"]) -> Float[np.ndarray, "ways rows columns 3"]:
        """The derivatives of the picture in some directions."""
        films = side_by_side(lambda part: _along(part, texels, ways), self.parts)
        return np.stack([self._whole([film[k] for film in films]) for k in range(len(ways))])

    def back(self, texels, cotangent: Float[np.ndarray, "rows columns 3"]) -> Float[np.ndarray, "height width 3"]:
        """The transpose of the derivative."""
        dtype = self.parts[0].scene.dtype
        plan = self.parts[0].plan
        films = dealt(jnp.asarray(cotangent, dtype), plan.passes, plan.pass_pixels)
        pairs = list(zip(self.parts, films, strict=True))
        found = side_by_side(lambda pair: _back(pair[0], texels, pair[1]), pairs)
        return np.asarray(np.sum(found, axis=0, dtype=np.float64))

    def _whole(self, films) -> np.ndarray:
        return np.asarray(gathered(jnp.stack(films), *self.size), np.float64)


@eqx.filter_jit
def _trees(part: MapPart, texels) -> Record:
    return record(part.tables(texels), part.camera, part.plan, part.samples)


@eqx.filter_jit
def _look(part: MapPart, texels):
    return part.shown(texels)


@eqx.filter_jit
def _along(part: MapPart, texels, ways):
    return jax.vmap(lambda way: jax.jvp(part.shown, (texels,), (way,))[1])(ways)


@eqx.filter_jit
def _back(part: MapPart, texels, film):
    return jax.vjp(lambda t: part.shown(t, False), texels)[1](film)[0]
