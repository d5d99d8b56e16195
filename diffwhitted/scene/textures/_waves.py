"""Plane waves."""

from typing import ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...numerics._safe import safe_divide, safe_sqrt
from ...numerics._vector import Vec3
from ...records import Row, changed, is_traced, require, rows_of
from ._pattern import COLOURS, AbstractPattern, left_of_wave, read_colours


class Waves(AbstractPattern):
    """v = 1/2 + 1/2 sum_k w_k sin(2 pi P.c_k / |c_k|**2): each wave by the vector c_k from one of its crests to the
    next, w_k = |c_k| / sum |c|, so that all are as steep.
    """

    TYPE: ClassVar[str] = "waves"
    ROWS: ClassVar[tuple[Row, ...]] = (
        COLOURS,
        Row("crests", "vectors", "For each wave the way from one crest to the next, metres.", unit="m", count=(1, 64),
            default=((1.0, 0.0, 0.0),), scale="unbounded", moves="patterns"),
    )  # fmt: skip

    colours: Float[Array, "2 3"]
    crests: Float[Array, "waves 3"]
    phase: Float[Array | np.ndarray, "waves"]
    """Parts of a wave by which they are ahead in the origin: 0, unless the pattern was moved."""

    def __init__(self, colours=COLOURS.default, crests=((1.0, 0.0, 0.0),), place: str = "texture"):
        self.colours = read_colours(colours, place)
        self.crests = rows_of(Waves)["crests"].read(crests, place)
        require(lambda c: (c != 0).any(axis=1).all(), place, "crests", self.crests, "any vectors but zero")
        self.phase = np.zeros(len(self.crests))

    def moved(self, by: np.ndarray) -> "Waves":
        crests = self.crests if is_traced(self.crests) else np.asarray(self.crests, np.float64)
        ahead = (crests @ by) / (crests * crests).sum(axis=1)
        return changed(self, phase=(self.phase - ahead) % 1)

    def finest(self):
        lengths = self._lengths()
        return jnp.min(lengths, axis=-1)

    def number(self, position: Vec3, width):
        lengths = self._lengths()
        shares = lengths / jnp.sum(lengths, axis=-1, keepdims=True)
        total = jnp.zeros_like(position.x)
        for k in range(self.crests.shape[-2]):
            x, y, z = (self.crests[..., k, axis] for axis in range(3))
            length = lengths[..., k]
            along = (position.x * x + position.y * y + position.z * z) * safe_divide(1, length * length)
            wave = jnp.sin(2 * jnp.pi * (along + self.phase[..., k]))
            total = total + wave * (shares[..., k] * left_of_wave(length, width))
        return 0.5 + 0.5 * total

    def _lengths(self) -> Float[Array, "... waves"]:
        x, y, z = (self.crests[..., axis] for axis in range(3))
        return safe_sqrt(x * x + y * y + z * z)
