"""Numbers, vectors, colours and transforms in POV-Ray's words."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...image import decode_signal
from .._numbers import LARGEST_NUMBER
from ..others._placed import translated, turned
from ._stream import Stream
from ._tokens import Token

CONSTANTS: dict[str, Any] = {
    "x": np.eye(3)[0], "y": np.eye(3)[1], "z": np.eye(3)[2], "pi": np.pi, "tau": 2 * np.pi, "on": 1.0, "off": 0.0,
    "yes": 1.0, "no": 0.0, "true": 1.0, "false": 0.0, "clock": 0.0, "version": 3.7,
}  # fmt: skip
FUNCTIONS: dict[str, tuple[int, Callable[..., Any]]] = {
    "sqrt": (1, np.sqrt), "abs": (1, np.abs), "sin": (1, np.sin), "cos": (1, np.cos), "tan": (1, np.tan),
    "asin": (1, np.arcsin), "acos": (1, np.arccos), "atan": (1, np.arctan), "atan2": (2, np.arctan2),
    "exp": (1, np.exp), "log": (1, np.log10), "ln": (1, np.log), "pow": (2, np.power), "floor": (1, np.floor),
    "ceil": (1, np.ceil), "int": (1, np.trunc), "mod": (2, np.fmod), "max": (2, np.maximum), "min": (2, np.minimum),
    "radians": (1, np.radians), "degrees": (1, np.degrees), "vlength": (1, np.linalg.norm),
    "vnormalize": (1, lambda v: v / np.linalg.norm(v)), "vcross": (2, np.cross), "vdot": (2, np.dot),
}  # fmt: skip
COLOURS = ("rgb", "rgbf", "rgbt", "rgbft", "srgb", "srgbf", "srgbt", "srgbft")
COLOURLESS = ("color", "colour")
CHANNELS = {"red": 0, "green": 1, "blue": 2, "filter": 3, "transmit": 4}
PARTS = CHANNELS | {"x": 0, "y": 1, "z": 2, "u": 0, "v": 1}
STANDARD: dict[str, tuple[float, ...]] = {
    "Black": (0, 0, 0), "White": (1, 1, 1), "Red": (1, 0, 0), "Green": (0, 1, 0), "Blue": (0, 0, 1),
    "Yellow": (1, 1, 0), "Cyan": (0, 1, 1), "Magenta": (1, 0, 1), "Clear": (1, 1, 1, 1),
    **{f"Gray{k:02d}": (k / 100,) * 3 for k in range(5, 100, 5)}, "Gray": (0.752941,) * 3, "Grey": (0.752941,) * 3,
    "Orange": (1, 0.5, 0), "Brown": (0.647059, 0.164706, 0.164706), "Gold": (0.8, 0.498039, 0.196078),
    "Silver": (0.90, 0.91, 0.98), "Pink": (0.737255, 0.560784, 0.560784), "Violet": (0.309804, 0.184314, 0.309804),
    "SkyBlue": (0.196078, 0.6, 0.8), "Navy": (0.137255, 0.137255, 0.556863), "Tan": (0.858824, 0.576471, 0.439216),
}  # fmt: skip
"""Of colors.inc, those that are used most."""


class Expressions:
    """Reads them from a stream."""

    def __init__(self, stream: Stream):
        self._stream = stream
        stream.expression = self.expression

    def expression(self) -> Any:
        """A number (float) or a vector (n,) of two to five. Raises `SceneError` naming the line."""
        first = self._product()
        while sign := self._stream.accept_here("+", "-"):
            one, other = _alike(first, self._product())
            first = self._checked(one + other if sign.text == "+" else one - other, sign)
        return first

    def number(self, of: str) -> float:
        """One number; of a vector the first, where all are alike."""
        token, found = self._stream.peek(), np.ravel(self.expression())
        if len(found) > 1 and np.ptp(found) > 0:
            raise token.error(f"a vector after {of}; allowed is a number")
        return float(found[0])

    def vector(self, of: str) -> np.ndarray:
        """(3,)."""
        token, found = self._stream.peek(), np.ravel(self.expression())
        if len(found) == 1:
            return np.full(3, found[0])
        if len(found) != 3:
            raise token.error(f"{len(found)} numbers after {of}; allowed is three, or one for all")
        return found

    def colour(self) -> np.ndarray:
        """Red, green, blue, filter, transmit."""
        token = self._stream.peek()
        while self._stream.accept(*COLOURLESS):
            pass
        found = np.zeros(5)
        if token.text in COLOURLESS:
            token = self._stream.peek()
        if token.text not in CHANNELS:
            value = np.ravel(self.expression())
            if len(value) == 2:
                raise token.error("two numbers for a colour; allowed is one, three, or up to five")
            found[: max(len(value), 3)] = value
        while channel := self._stream.accept_here(*CHANNELS):
            found[CHANNELS[channel.text]] = self.number(channel.text)
        if (found < 0).any():
            raise token.error(f"a colour {found.tolist()}; allowed is >= 0")
        return found

    def transform(self, token: Token) -> np.ndarray | None:
        """The matrix (4, 4) of a word that begins a transform; None for another word."""
        stream, word = self._stream, token.text
        if word == "translate":
            return translated(self.vector(word))
        if word == "scale":
            factors = self.vector(word)
            if (factors == 0).any():
                # As POV-Ray does, with a warning.
                factors = np.where(factors == 0, 1.0, factors)
            return np.diag([*factors, 1.0])
        if word == "rotate":
            return _rotated(np.radians(self.vector(word)))
        if word == "matrix":
            return self._matrix(token)
        if word != "transform":
            return None
        if stream.peek().text != "{":
            return self._declared(stream.take())
        found = np.eye(4)
        for step in stream.block(token):
            one = self.transform(step)
            one = self._declared(step) if one is None else one
            found = one @ found
        return found

    def _declared(self, token: Token) -> np.ndarray:
        value = self._stream.values.get(token.text)
        if token.text == "inverse" or not (isinstance(value, np.ndarray) and value.shape == (4, 4)):
            raise token.error(f"{token.said()} is no transform; allowed are translate, rotate, scale, matrix")
        return value

    def _matrix(self, token: Token) -> np.ndarray:
        """Rows of where the axes and the origin go."""
        stream = self._stream
        stream.expect("<", "matrix")
        numbers = []
        for _ in range(12):
            numbers.append(self.number("matrix"))
            stream.comma()
        stream.expect(">", "matrix")
        found = np.eye(4)
        found[:3] = np.reshape(numbers, (4, 3)).T
        return found

    def _product(self) -> Any:
        first = self._factor()
        while sign := self._stream.accept_here("*", "/"):
            one, other = _alike(first, self._factor())
            if sign.text == "/" and np.any(np.asarray(other) == 0) and np.ndim(other) == 0:
                raise sign.error("a division by 0")
            with np.errstate(all="ignore"):
                first = self._checked(one * other if sign.text == "*" else _divided(one, other), sign)
        return first

    def _factor(self) -> Any:
        stream = self._stream
        signs = 1.0
        while sign := stream.accept("-", "+", "!"):
            if sign.text == "!":
                return float(not np.any(self._factor()))
            signs *= -1.0 if sign.text == "-" else 1.0
        token = stream.take()
        with stream.deeper(token):
            found = self._one(token)
        while stream.accept_here("."):
            part = stream.take()
            if part.text not in PARTS or PARTS[part.text] >= len(np.ravel(found)):
                raise part.error(f".{part.text[:20]} of a vector; allowed is x, y, z, red, green, blue")
            found = float(np.ravel(found)[PARTS[part.text]])
        return signs * found

    def _one(self, token: Token) -> Any:
        stream, word = self._stream, token.text
        if token.kind == "number":
            return self._checked(float(word), token)
        if word == "(":
            found = self.expression()
            stream.expect(")", "an expression")
            return found
        if word == "<":
            return self._vector(token)
        if token.kind == "word":
            if word in COLOURS or word in ("color", "colour"):
                return self._coloured(token)
            if word in FUNCTIONS and stream.peek().text == "(":
                return self._function(token)
            if word in stream.values:
                value = stream.values[word]
                if isinstance(value, float) or (isinstance(value, np.ndarray) and value.ndim == 1):
                    return value
                raise token.error(f"{word[:40]} is no number; allowed is a number or a vector here")
            if word in CONSTANTS:
                return CONSTANTS[word]
            if word in STANDARD and "colors.inc" in stream.includes:
                return np.asarray([*STANDARD[word], *[0.0] * (5 - len(STANDARD[word]))], float)
        raise token.error(f"{token.said()} where a number or a vector should be; is it declared above?")

    def _vector(self, token: Token) -> np.ndarray:
        stream, found = self._stream, []
        while not stream.accept(">"):
            if len(found) == 5:
                raise token.error("a vector of more than five numbers; allowed is two to five")
            found.append(self.number("<"))
            stream.comma()
        if len(found) < 2:
            raise token.error(f"a vector of {len(found)} numbers; allowed is two to five")
        return np.asarray(found)

    def _coloured(self, token: Token) -> np.ndarray:
        if token.text in ("color", "colour"):
            return self.colour()
        value, kind = np.ravel(self.expression()), token.text.removeprefix("s")[3:]
        found = np.zeros(5)
        if len(value) == 2:
            raise token.error(f"{token.text} of two numbers; allowed is one, three, or up to five")
        found[:3] = value[:3] if len(value) > 1 else value[0]
        if token.text.startswith("s"):
            found[:3] = decode_signal(found[:3], "srgb")
        for k, letter in enumerate(kind):
            found[3 if letter == "f" else 4] = value[3 + k] if len(value) > 3 + k else value[0] * (len(value) == 1)
        return found

    def _function(self, token: Token) -> Any:
        stream, (count, make) = self._stream, FUNCTIONS[token.text]
        stream.expect("(", token.text)
        found = [self.expression()]
        while stream.accept(","):
            found.append(self.expression())
        stream.expect(")", token.text)
        if len(found) != count:
            raise token.error(f"{token.text} of {len(found)} numbers; allowed is {count}")
        with np.errstate(all="ignore"):
            try:
                value = make(*found)
            except (ValueError, TypeError):
                raise token.error(f"{token.text} of vectors that do not fit") from None
        return self._checked(float(value) if np.ndim(value) == 0 else value, token)

    def _checked(self, value: Any, token: Token) -> Any:
        if not np.isfinite(value).all() or np.abs(value).max() > LARGEST_NUMBER:
            raise token.error(f"a number at {token.said()} is not finite, or above 1e30")
        return value


def _alike(one: Any, other: Any) -> tuple[Any, Any]:
    """Vectors of one length: the shorter is filled with zeros."""
    if np.ndim(one) and np.ndim(other) and len(one) != len(other):
        size = max(len(one), len(other))
        one, other = (np.concatenate([v, np.zeros(size - len(v))]) for v in (one, other))
    return one, other


def _divided(one: Any, other: Any) -> Any:
    """Channels that are 0 in both stay 0, as filter and transmit of colours."""
    if np.ndim(other) == 0:
        return one / other
    one = one * np.ones_like(other)
    return np.divide(one, other, out=np.where(one == 0, 0.0, np.inf), where=np.asarray(other) != 0)


def _rotated(angles: np.ndarray) -> np.ndarray:
    """About x, then y, then z, as POV-Ray's left-handed axes have it: the same matrices on columns."""
    x, y, z = angles
    return turned(2, z) @ turned(1, y) @ turned(0, x)
