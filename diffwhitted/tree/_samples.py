"""Where the camera rays of a pass go."""

from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..scene import AbstractCamera
from ._plan import Plan


class Samples(eqx.Module):
    """Places in the picture, one a camera ray of a pass; (0.5, 0.5) is the centre of the first pixel, top left."""

    column: Float[Array, "n"]
    row: Float[Array, "n"]
    there: Bool[Array, "n"]
    """False: no ray, and 0 on the film."""
    side: Float[Array, ""]
    """Of the square that each stands for, in pixels; of no meaning where rays have no footprint."""
    draw: Int[Array, ""]
    """Which of the pixel's samples it is (see `drawn`): it decides on the band and on what is left to chance."""
    place: Int[Array, "n"] | None = None
    """The number of the place in the pixel, where each draws by itself what is left to chance; None: they draw
    together, by `draw`.
    """


class Draw(eqx.Module):
    """Samples of a pixel: a place in it (column, row; 0.5, 0.5 the middle), and their numbers."""

    place: Float[Array, "*samples 2"]
    number: Int[Array, "*samples"]


class Window(eqx.Module):
    """Some of the samples of a pass: `size` of them from the `first` on."""

    first: Int[Array, ""]
    size: Int[Array, ""]

    def of(self, plan: Plan, samples: Samples) -> tuple[Samples, Int[Array, ""]]:
        """The samples without those outside, and the slots that camera rays take, in whole blocks."""
        number = jnp.arange(plan.pass_pixels, dtype=jnp.int32)
        inside = (number >= self.first) & (number < self.first + self.size)
        blocks = (jnp.minimum(self.size, plan.pass_pixels) + plan.block - 1) // plan.block
        return replace(samples, there=samples.there & inside), blocks * plan.block

    def given(self, plan: Plan, given):
        """Tables, camera and samples without those outside."""
        return (*given[:-1], self.of(plan, given[-1])[0])

    def sample(self, plan: Plan, slot: Int[Array, "n"]) -> Int[Array, "n"]:
        """The sample of each slot of camera rays; past the end of the pass one outside the window."""
        number = self.first + slot
        return jnp.where(number < plan.pass_pixels, number, 0)


def grid(
    plan: Plan,
    camera: AbstractCamera,
    number: Int[Array, ""],
    draw: Draw | Float[Array, "*one 2"] | Float[np.ndarray, "2"],
    side=None,
) -> Samples:
    """The regular samples of pass `number`: one a pixel; of a place alone the first one there.

    `side` of the square that each stands for, in pixels; without it, that of the plan's footprint.
    """
    draw = draw if isinstance(draw, Draw) else Draw(draw, jnp.int32(0))
    pixel = pixel_of(plan, number, jnp.arange(plan.pass_pixels, dtype=jnp.int32))
    last = camera.width * camera.height - 1
    column, row = camera.place(jnp.minimum(pixel, last), draw.place)
    return Samples(
        column,
        row,
        pixel <= last,
        jnp.asarray(1 / max(plan.footprint, 1) if side is None else side, column.dtype),
        draw.number,
    )


def pixel_of(plan: Plan, number, sample):
    """The pixel, counted row by row, of a sample of pass `number`: pass p of n holds the pixels p, p + n, p + 2 n,
    ... (see `image.dealt`).
    """
    return number + plan.passes * sample


def drawn(plan: Plan, places: Float[Array, "places 2"]) -> Draw:
    """The samples of a pixel at these places, so many times over as bands and chance ask for; their mean is the pixel.

    Sample `number` is of band `number` mod `plan.bands`; those of one place follow each other, and those of one place
    and one band differ in what is left to chance.
    """
    times = -(-plan.chances // len(places))
    return Draw(
        jnp.repeat(places, times * plan.bands, axis=0), jnp.arange(times * len(places) * plan.bands, dtype=jnp.int32)
    )


def sample_places(side: int, dtype) -> Float[Array, "samples 2"]:
    """Places (column, row) in a pixel, the middles of side x side squares."""
    steps = (np.arange(side) + 0.5) / side
    return jnp.asarray([(column, row) for row in steps for column in steps], dtype)
