"""What a fit looks at: each target in parts that a program takes one at a time; all of it, a share of it, coarser, or
finer.

A view of any kind has parts of one shape, so that one compiled program serves them all.
"""

from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from diffwhitted.image import dealt, gathered
from diffwhitted.scene import Marks
from diffwhitted.tree import Plan, Record, Samples, sample_places

PART_PIXELS, PART_RAYS = 20_000, 2_000
"""A target is looked at in passes of no more pixels and blocks of no more rays: with a column for each unknown,
larger ones outgrow the cache, and the memory of larger passes is fetched anew for each look (measured with 18
unknowns).
"""


class Part(eqx.Module):
    """One pass of a target."""

    target: Float[Array, "3 pixels"]
    weight: Float[Array, "pixels"]
    """Square root of the mask over the noise, divided by the root of the number of residuals."""
    column: Float[Array, "pixels"]
    """Of the upper left corner of each pixel, as `row`."""
    row: Float[Array, "pixels"]
    there: Bool[Array, "pixels"]
    places: Float[Array, "samples 2"]
    """Where in each pixel the samples are. Where rays move it is one: a pass is as many parts as there are samples a
    pixel.
    """
    side: Float[Array, ""]
    """Of the square that a sample stands for, in pixels."""
    trees: Record | None
    """The recorded trees (samples, ...); None where rays move, so that each evaluation records."""
    marks: Marks
    """Of the scene, whose values are traced in the programs of a fit."""
    plan: Plan = eqx.field(static=True)
    camera: str = eqx.field(static=True)
    """Its name in the scene, whose camera a fit may move."""

    def samples(self, place: Float[Array, "2"]) -> Samples:
        """Where the rays of one sample a pixel go."""
        return Samples(self.column + place[0], self.row + place[1], self.there, self.side)


class View(eqx.Module):
    """A target: its parts, one for each pass and each group of places in a pixel, pass by pass."""

    parts: tuple[Part, ...]
    image: np.ndarray
    """(height, width, 3)."""
    weight: np.ndarray
    """(height, width)."""
    passes: int
    step: int
    """Its pixels are squares of step x step pixels of the camera."""

    def picture(
        self, film: Float[Array | np.ndarray, "passes channels pixels"]
    ) -> Float[Array, "height width channels"]:
        """The passes put together."""
        return gathered(film, *self.weight.shape)


def view_of(
    camera: str,
    image: np.ndarray,
    weight: np.ndarray,
    places: Float[Array, "groups samples 2"],
    side: float,
    plan: Plan,
    marks: Marks,
    step: int = 1,
) -> View:
    """A target without trees, whose samples stand for squares of `side` pixels; `step`: see `View`."""
    dtype, (height, width) = places.dtype, weight.shape
    passes = -(-height * width // plan.pass_pixels) if step > 1 else plan.passes
    row, column = np.mgrid[:height, :width] * float(step)
    content = np.concatenate(
        [image, weight[..., None], column[..., None], row[..., None], np.ones_like(weight)[..., None]], axis=-1
    )
    each = dealt(jnp.asarray(content, dtype), passes, plan.pass_pixels)
    parts = [
        Part(
            each[n, :3],
            each[n, 3],
            each[n, 4],
            each[n, 5],
            each[n, 6] > 0,
            group,
            jnp.asarray(side, dtype),
            None,
            marks,
            plan,
            camera,
        )
        for group in places
        for n in range(passes)
    ]
    return View(tuple(parts), image, weight, passes, step)


def coarser(view: View, step: int) -> View:
    """Squares of step x step pixels as one sample with the mean of its pixels; where rays move."""
    if step == 1:
        return view
    height, width = view.weight.shape
    room = ((0, -height % step), (0, -width % step))
    squared = np.pad(view.weight.astype(np.float64) ** 2, room)
    weighted = np.pad(view.image, (*room, (0, 0))) * squared[..., None]
    total = _squares(squared[..., None], step)
    image = np.divide(_squares(weighted, step), total, out=np.zeros((*total.shape[:2], 3)), where=total > 0)
    part = view.parts[0]
    middle = jnp.full_like(part.places, step / 2)[None]
    return view_of(part.camera, image, np.sqrt(total[..., 0]), middle, step, part.plan, part.marks, step)


def _squares(picture: np.ndarray, step: int) -> np.ndarray:
    """The sums over squares of step x step pixels."""
    height, width, channels = picture.shape
    return picture.reshape(height // step, step, width // step, step, channels).sum(axis=(1, 3))


def some_passes(view: View, count: int) -> View:
    """`count` of the passes, each of which has pixels from all over the picture, with the weight of them all."""
    chosen = [number * view.passes // count for number in range(count)]
    heavier = (view.passes / count) ** 0.5
    parts = [part for n, part in enumerate(view.parts) if n % view.passes in chosen]
    return replace(view, parts=tuple(replace(part, weight=part.weight * heavier) for part in parts), passes=count)


def finer(view: View) -> View:
    """2 x 2 samples in place of one; where rays move, whose parts have one sample."""

    def quarter(part: Part, place) -> Part:
        return replace(part, places=part.places + (place - 0.5) * part.side, side=part.side / 2)

    groups = [view.parts[n : n + view.passes] for n in range(0, len(view.parts), view.passes)]
    quarters = sample_places(2, view.parts[0].places.dtype)
    return replace(view, parts=tuple(quarter(part, place) for group in groups for place in quarters for part in group))
