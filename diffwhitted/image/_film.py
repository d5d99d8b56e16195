"""Film: the pixels of a picture dealt out to passes, and gathered from them.

Pass p of n holds the pixels p, p + n, p + 2 n, ... counted row by row, so that every pass sees a thinned-out
version of the whole picture and all passes cost about the same.
"""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float


@partial(jax.jit, static_argnums=(1, 2))
def dealt(
    image: Float[Array, "height width channels"], passes: int, pass_pixels: int
) -> Float[Array, "passes channels pixels"]:
    """A picture dealt out to `passes` of `pass_pixels` each, with zeros past its end."""
    flat = jnp.reshape(image, (-1, image.shape[-1]))
    flat = jnp.pad(flat, ((0, passes * pass_pixels - flat.shape[0]), (0, 0)))
    return flat.reshape(pass_pixels, passes, -1).transpose(1, 2, 0)


@partial(jax.jit, static_argnums=(1, 2))
def gathered(
    film: Float[Array, "passes channels pixels"], height: int, width: int
) -> Float[Array, "height width channels"]:
    """The inverse of `dealt`."""
    flat = film.transpose(2, 0, 1).reshape(-1, film.shape[1])
    return flat[: height * width].reshape(height, width, -1)
