"""Pixels that see further than their own square: a wider filter is a linear map from samples to pixels.

It takes light and derivatives alike, after rays are traced and before the shot makes a picture of the light.
"""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from diffwhitted.image import dealt, gathered
from diffwhitted.image._filters import filter_matrix
from diffwhitted.scene import PixelFilter


class Filtering:
    """The sum over samples so far, of pictures (height, width, ...), for one filter."""

    def __init__(self, kind: PixelFilter, height: int, width: int):
        self.kind: PixelFilter = kind
        self.size = height, width
        self.total: Array | np.ndarray | float = 0.0
        self.weight = np.zeros((height, width))

    def add(self, pictures: Float[Array, "height width columns"], place: Sequence[float]) -> None:
        """What the samples at `place` (column, row) of all pixels see."""
        across, down = (filter_matrix(self.kind, n, float(p)) for n, p in zip(self.size[::-1], place, strict=True))
        self.total = self.total + _spread(
            jnp.asarray(down, pictures.dtype), pictures, jnp.asarray(across, pictures.dtype)
        )
        self.weight += np.outer(down.sum(axis=1), across.sum(axis=1))

    @property
    def pictures(self) -> Float[Array, "height width columns"]:
        """The weighted means."""
        total = jnp.asarray(self.total)
        return total / jnp.asarray(self.weight, total.dtype)[..., None]

    def add_passes(self, film: Float[Array, "passes columns pixels"], place: Sequence[float]) -> None:
        """The same of pictures that are dealt out to passes."""
        self.add(gathered(film, *self.size), place)

    def passes(self, count: int, pixels: int) -> Float[Array, "passes columns pixels"]:
        """The weighted means, dealt out."""
        return dealt(self.pictures, count, pixels)


@jax.jit
def _spread(down, pictures, across):
    return jnp.einsum("ij,jkc,lk->ilc", down, pictures, across)
