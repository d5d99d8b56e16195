"""The edges of the light of a lamp that does not shine to all sides."""

import equinox as eqx
from jaxtyping import Array, Float


class Border(eqx.Module):
    """An edge of light at points: there is light where `value` > 0.

    With a `width` the light rises from 0 at value = 0 to all of it at value = width, by s^2 (3 - 2 s) with s =
    value / width; None: all at once.
    """

    value: Float[Array, "*n"]
    width: Float[Array, "*n"] | None = None


Borders = tuple[tuple[Border, ...], ...]
"""Sets of edges that run side by side, such as the two of a pair of flaps; light passes where it passes all of them."""
