"""The numbers that a file stores, the light they stand for, and the light that each of them may stand for."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ._statements import Decoding

_LARGEST_HALF = 65504.0


@dataclass(frozen=True, eq=False)
class Codes:
    """Stored numbers of colour, (height, width, 1 or 3), and how light follows from them.

    bits: of a code; 0 for floats, of 16 bits where `half`. opacity: what the numbers were multiplied by, None for 1.
    exact: is a code the nearest to what was written? mantissa: bits of a number that shares its exponent, or 0.
    """

    stored: np.ndarray
    decoding: Decoding
    opacity: Float[np.ndarray, "height width"] | None
    exposure: float
    bits: int
    half: bool
    exact: bool
    mantissa: int

    def light(self) -> Float[np.ndarray, "height width channels"]:
        """The light of the numbers through their curves, before any matrix and exposure; float32."""
        if self.bits and self.opacity is None:
            largest = np.iinfo(self.stored.dtype).max
            table = self._decoded((np.arange(largest + 1) / largest)[:, None]).astype(np.float32)
            return self._looked_up(table, self.stored)
        signal = unit(self.stored) if self.opacity is None else unit(self.stored) / self.opacity[..., None]
        return signal if self.decoding.encoding == "linear" else self._decoded(signal).astype(np.float32)

    def cells(self) -> tuple[np.ndarray, np.ndarray] | None:
        """The lowest and the highest light that is stored as these numbers; None where that is not known."""
        if not self.exact or not (self.bits or self.half):
            return None
        if self.decoding.matrix is not None or self.opacity is not None:
            return None
        low, high = self._edges()
        if self.bits:
            lowest, highest = self._numbers() == 0, self._numbers() == 2**self.bits - 1
        else:
            lowest, highest = self.stored <= -_LARGEST_HALF, self.stored >= _LARGEST_HALF
        low, high = np.where(lowest, -np.inf, low), np.where(highest, np.inf, high)
        return three(low / self.exposure), three(high / self.exposure)

    def step(self) -> Float[np.ndarray, "height width 3"] | None:
        """The width of a code in linear light; None for floats of 32 bits."""
        if self.mantissa:
            brightest = unit(self.stored).max(axis=2, keepdims=True)
            width = np.ldexp(1.0, np.frexp(brightest)[1] - self.mantissa)
        elif self.bits or self.half:
            low, high = self._edges()
            width = high - low
            if self.bits:
                # Half of the cell of the first and of the last code is outside the curve.
                ends = (self._numbers() == 0) | (self._numbers() == 2**self.bits - 1)
                width = np.where(ends, 2 * width, width)
        else:
            return None
        width = three(width / self.exposure)
        return width if self.decoding.matrix is None else np.sqrt(width**2 @ self.decoding.matrix.T**2)

    def _numbers(self) -> np.ndarray:
        """Codes as whole numbers from 0 to 2^bits - 1: OpenImageIO spreads 1 to 7 bits over 8, and 9 to 15 over 16."""
        largest = np.iinfo(self.stored.dtype).max
        if largest == 2**self.bits - 1:
            return self.stored
        return np.rint(self.stored * ((2**self.bits - 1) / largest)).astype(self.stored.dtype)

    def _edges(self) -> tuple[np.ndarray, np.ndarray]:
        """The light half a code below and above, but within the range of codes."""
        if self.half:
            number = self.stored.astype(np.float16)
            below, above = (np.nextafter(number, np.float16(end)).astype(np.float64) for end in (-np.inf, np.inf))
            below, above = ((self.stored + next_to) / 2 for next_to in (below, above))
            opacity = 1 if self.opacity is None else self.opacity[..., None]
            return self._decoded(below / opacity), self._decoded(above / opacity)
        largest = 2**self.bits - 1
        codes = self._numbers()
        if self.opacity is not None:
            scale = largest * self.opacity[..., None]
            low, high = np.maximum(codes - 0.5, 0), np.minimum(codes + 0.5, largest)
            return self._decoded(low / scale), self._decoded(high / scale)
        edges = np.clip(np.arange(largest + 2) - 0.5, 0, largest) / largest
        table = self._decoded(edges[:, None])
        return self._looked_up(table[:-1], codes), self._looked_up(table[1:], codes)

    def _decoded(self, signal: np.ndarray) -> np.ndarray:
        """The light of a signal, (..., channels), float64; of one channel for all, or of each by its own curve."""
        curves = self.decoding.curves
        if len(curves) == 1:
            return curves[0](signal.astype(np.float64))
        if self.stored.shape[2] == 1:
            return curves[1](signal.astype(np.float64))
        columns = np.broadcast_to(signal, (*signal.shape[:-1], 3)).astype(np.float64)
        return np.stack([curve(columns[..., channel]) for channel, curve in enumerate(curves)], axis=-1)

    def _looked_up(self, table: Float[np.ndarray, "codes curves"], codes: np.ndarray) -> np.ndarray:
        """The entries of a table, by its only column or by the column of each channel."""
        return table[:, 0][codes] if table.shape[1] == 1 else table[codes, np.arange(codes.shape[2])]


def unit(values: np.ndarray) -> Float[np.ndarray, "..."]:
    """float32: whole numbers as fractions of their largest, floats as they are."""
    if np.issubdtype(values.dtype, np.integer):
        return (values / np.iinfo(values.dtype).max).astype(np.float32)
    return values.astype(np.float32, copy=False)


def three(values: np.ndarray) -> Float[np.ndarray, "height width 3"]:
    """Grey as three equal channels, contiguous."""
    return np.ascontiguousarray(np.broadcast_to(values, (*values.shape[:2], 3)))
