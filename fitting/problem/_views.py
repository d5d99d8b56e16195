"""What a fit looks at: each target in parts that a program takes one at a time; all of it, a share of it, coarser, or
finer.

Parts of one shape share a compiled program, whichever shot, camera or lamps they belong to.
"""

from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from diffwhitted.image import dealt, gathered
from diffwhitted.scene import Marks, PixelFilter
from diffwhitted.tree import Plan, Record, Samples, drawn, sample_places

from ._sight import Sight

PART_PIXELS, PART_RAYS = 20_000, 2_000
"""A target is looked at in passes of no more pixels and blocks of no more rays: with a column for each unknown,
larger ones outgrow the cache, and the memory of larger passes is fetched anew for each look (measured with 18
unknowns).
"""


class Part(eqx.Module):
    """One pass of a target, at one place in each of its pixels."""

    target: Float[Array, "3 pixels"]
    weight: Float[Array, "3 pixels"]
    """Square root of the mask over the noise, divided by the root of the number of residuals."""
    column: Float[Array, "pixels"]
    """Of the upper left corner of each pixel, as `row`."""
    row: Float[Array, "pixels"]
    there: Bool[Array, "pixels"]
    place: Float[Array, "2"]
    """Where in each pixel the sample is: a pass is as many parts as there are samples a pixel."""
    draw: Int[Array, ""]
    """The number of the sample (see `drawn`)."""
    side: Float[Array, ""]
    """Of the square that a sample stands for, in pixels."""
    sight: Sight
    trees: Record | None
    """The recorded trees; None where rays move, so that each evaluation records."""
    marks: Marks
    """Of the scene, whose values are traced in the programs of a fit."""
    plan: Plan = eqx.field(static=True)

    @property
    def samples(self) -> Samples:
        """Where the rays of the pixels go."""
        return Samples(self.column + self.place[0], self.row + self.place[1], self.there, self.side, self.draw)


class View(eqx.Module):
    """A target: its parts, one for each pass and each place in a pixel, place by place."""

    parts: tuple[Part, ...]
    image: np.ndarray
    """(height, width, 3)."""
    weight: np.ndarray
    """(height, width, 3)."""
    passes: int
    step: int
    """Its pixels are squares of step x step pixels of the camera."""
    filter: PixelFilter = eqx.field(static=True, default="box")
    """How the samples around a pixel count for it."""

    def picture(
        self, film: Float[Array | np.ndarray, "passes channels pixels"]
    ) -> Float[Array, "height width channels"]:
        """The passes put together."""
        return gathered(film, *self.weight.shape[:2])

    def places_of(self, number: int) -> tuple[Part, ...]:
        """The parts of one pass."""
        return self.parts[number :: self.passes]


def view_of(
    sight: Sight,
    image: np.ndarray,
    weight: np.ndarray,
    places: Float[Array, "places 2"],
    side: float,
    plan: Plan,
    marks: Marks,
    step: int = 1,
) -> View:
    """A target without trees, whose samples stand for squares of `side` pixels; `step`: see `View`.

    `weight`: of each pixel (height, width), or of each of its channels (height, width, 3).
    """
    dtype, (height, width) = places.dtype, weight.shape[:2]
    weight = np.broadcast_to(weight if weight.ndim == 3 else weight[..., None], image.shape)
    passes = -(-height * width // plan.pass_pixels) if step > 1 else plan.passes
    row, column = np.mgrid[:height, :width] * float(step)
    content = np.concatenate([image, weight, column[..., None], row[..., None], np.ones((height, width, 1))], axis=-1)
    each = dealt(jnp.asarray(content, dtype), passes, plan.pass_pixels)
    side_of = jnp.asarray(side, dtype)
    draws = drawn(plan, places)
    parts = [
        Part(
            each[n, :3], each[n, 3:6], each[n, 6], each[n, 7], each[n, 8] > 0, place, draw, side_of, sight, None, marks,
            plan,
        )
        for place, draw in zip(draws.place, draws.number, strict=True)
        for n in range(passes)
    ]  # fmt: skip
    return View(tuple(parts), image, weight, passes, step)


def coarser(view: View, step: int) -> View:
    """Squares of step x step pixels as one sample with the mean of its pixels; where rays move."""
    if step == 1:
        return view
    # Squares of several pixels hardly notice how wide a pixel sees: the new view has the plain filter.
    height, width = view.weight.shape[:2]
    room = ((0, -height % step), (0, -width % step), (0, 0))
    squared = np.pad(view.weight.astype(np.float64) ** 2, room)
    total = _squares(squared, step)
    weighted = _squares(np.pad(view.image, room) * squared, step)
    image = np.divide(weighted, total, out=np.zeros_like(total), where=total > 0)
    part = view.parts[0]
    middle = jnp.full((1, 2), step / 2, part.place.dtype)
    return view_of(part.sight, image, np.sqrt(total), middle, step, part.plan, part.marks, step)


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
    """2 x 2 samples in place of one; where rays move."""

    def quarter(part: Part, number: int, place) -> Part:
        # Of the same band, and by chance another one.
        bands = part.plan.bands
        draw = part.draw % bands + bands * (part.draw // bands * 4 + number)
        return replace(part, place=part.place + (place - 0.5) * part.side, side=part.side / 2, draw=draw)

    groups = [view.parts[n : n + view.passes] for n in range(0, len(view.parts), view.passes)]
    quarters = sample_places(2, view.parts[0].place.dtype)
    parts = (quarter(part, k, place) for group in groups for k, place in enumerate(quarters) for part in group)
    return replace(view, parts=tuple(parts))


def reweighted(view: View, weight: np.ndarray) -> View:
    """The view with other weights, (height, width, 3)."""
    plan = view.parts[0].plan
    each = dealt(jnp.asarray(weight, view.parts[0].weight.dtype), view.passes, plan.pass_pixels)
    parts = tuple(replace(part, weight=each[n % view.passes]) for n, part in enumerate(view.parts))
    return replace(view, parts=parts, weight=weight)


def retargeted(view: View, image: np.ndarray) -> View:
    """The view with another target, (height, width, 3)."""
    plan = view.parts[0].plan
    each = dealt(jnp.asarray(image, view.parts[0].target.dtype), view.passes, plan.pass_pixels)
    parts = tuple(replace(part, target=each[n % view.passes]) for n, part in enumerate(view.parts))
    return replace(view, parts=parts, image=image)


def at_places(view: View, places: Float[Array, "places 2"]) -> View:
    """The view with one sample at each of these places in every pixel, not yet traced; where no ray moves."""
    passes, draws = view.parts[: view.passes], drawn(view.parts[0].plan, places)
    return replace(
        view,
        parts=tuple(
            replace(part, place=place, draw=draw, trees=None)
            for place, draw in zip(draws.place, draws.number, strict=True)
            for part in passes
        ),
    )
