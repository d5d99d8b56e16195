"""A scene out of a POV-Ray file: the reverse of the writer, and what people write by hand, as far as our model goes."""

from typing import Any

import numpy as np

from ..._errors import SceneError
from ...scene import ConstantBackground, GradientBackground, Precision, Scene
from ..others._found import Found
from ._coats import Pigment
from ._expressions import Expressions
from ._objects import LEFT, Objects
from ._scenery import Lamps, Views, is_right_handed
from ._stream import Stream
from ._textures import Finish, Interior, Sky, Textures
from ._tokens import Token

FLIP = np.diag([1.0, 1.0, -1.0, 1.0])
SKIPPED = ("fog", "rainbow", "media", "density")
LARGEST_DEPTH = 64
USUAL_CUTOFF = 1 / 255
"""adc_bailout where none is stated."""


def parse_povray(data: bytes, source: str, precision: Precision) -> Scene:
    """The scene in the bytes of a file. Raises `SceneError` that names the line; a `SceneNote` says what is lost."""
    try:
        return _Reading(data, source).scene(precision)
    except RecursionError:
        raise SceneError(f"{source}: brackets within brackets too deep to be read; allowed is fewer") from None


class _Reading:
    """What has been read so far."""

    def __init__(self, data: bytes, source: str):
        self._found = Found(source, "POV-Ray")
        lost = self._found.lost
        self._stream = Stream(data, source)
        self._read = Expressions(self._stream)
        self._textures = Textures(self._stream, self._read, lost)
        self._objects = Objects(self._stream, self._read, self._textures, lost)
        self._views, self._lamps = Views(self._stream, self._read, lost), Lamps(self._stream, self._read, lost)
        self._shapes: list[Any] = []
        self._background: Any = ConstantBackground((0.0, 0.0, 0.0))
        self._settings: dict[str, Any] = {
            "ambient": np.ones(3), "max_depth": 5, "cutoff": USUAL_CUTOFF
        }  # fmt: skip
        self._stream.declared, self._stream.default = self._declared, self._default
        self._stream.left_out = lambda token: self._views.add(self._stream.take(), further=True)
        self._views.declare_size(data)

    def scene(self, precision: Precision) -> Scene:
        """The scene of the whole file."""
        while (token := self._stream.take()).kind != "end":
            self._statement(token)
        # Turn z round, unless the file has turned x round for its cameras.
        flip = np.eye(4) if is_right_handed(self._views.found) else FLIP
        found = self._found
        hidden = [shape for shape in self._shapes if shape.unseen]
        seen = [shape for shape in self._shapes if not shape.unseen]
        for shape in seen:
            self._objects.add(shape, found, flip)
        self._views.make(found, flip)
        self._lamps.make(found, flip)
        return found.scene(
            background=self._background,
            shadows=self._shadows(seen, hidden),
            total_internal_reflection="full",
            precision=precision,
            **self._settings,
        )

    def _shadows(self, seen: list, hidden: list) -> str:
        """Tinted, as POV-Ray's are; opaque where what casts no shadow has a twin that is one."""
        shadowless = [shape for shape in seen if shape.shadowless]
        if hidden and len(shadowless) >= len(hidden):
            return "opaque"
        if hidden:
            self._found.lost.say("left out: what is not to be seen (no_image)")
        if shadowless and len(shadowless) == len(seen):
            return "off"
        if shadowless:
            self._found.lost.say("no_shadow is lost: all things cast shadows")
        return "tinted"

    def _statement(self, token: Token) -> None:
        stream, word = self._stream, token.text
        if token.kind == "word" and self._objects.begins(token):
            if (shape := self._objects.read(token)) is not None:
                self._shapes.append(shape)
        elif word == "camera":
            self._views.add(token)
        elif word == "light_source":
            self._lamps.add(token)
        elif word == "background":
            for inner in stream.block(token):
                stream.give_back(inner)
                self._background = ConstantBackground(self._read.colour()[:3])
        elif word == "sky_sphere":
            self._sky(token)
        elif word == "global_settings":
            self._global(token)
        elif word in SKIPPED:
            self._found.lost.say(f"{word} is lost")
            stream.skip_block(token)
        elif word != ";":
            raise token.error(
                f"{token.said()} is no statement that is read; allowed are camera, light_source, background, "
                "sky_sphere, global_settings, shapes and #declare"
            )

    def _sky(self, token: Token) -> None:
        """From straight down to straight up, where it is a gradient of two colours."""
        matrix, sky, pigment = np.eye(4), None, None
        for word in self._stream.block(token):
            if word.text == "pigment":
                pigment, sky = self._textures.pattern(Token("word", "sky", word.line, word.file))
            else:
                step = self._read.transform(word)
                if step is None:
                    raise word.error(f"{word.said()} in a sky_sphere; allowed are pigment and transforms")
                matrix = step @ matrix
        ends = None if sky is None else _ends(sky, matrix)
        if ends is not None:
            self._background = GradientBackground(*ends)
        elif pigment is not None:
            if len(pigment.colours) > 1 or sky is not None:
                self._textures.gradient_lost("the sky")
            self._background = ConstantBackground(np.mean(pigment.colours, axis=0)[:3])

    def _global(self, token: Token) -> None:
        stream, read, settings = self._stream, self._read, self._settings
        for word in stream.block(token):
            if word.text == "max_trace_level":
                level = read.number(word.text)
                if not (level.is_integer() and level >= 1):
                    raise word.error(f"max_trace_level {level:g}; allowed is a whole number from 1")
                settings["max_depth"] = min(int(level), LARGEST_DEPTH)
            elif word.text == "adc_bailout":
                settings["cutoff"] = read.number(word.text)
            elif word.text == "ambient_light":
                settings["ambient"] = read.colour()[:3]
            elif word.text == "assumed_gamma":
                if stream.accept("srgb") or read.number(word.text) != 1:
                    self._found.lost.say("assumed_gamma is lost: colours are linear")
            elif stream.peek().text == "{":
                self._found.lost.say(f"{word.text[:40]} is lost")
                stream.skip_block(word)
            else:
                self._found.lost.say(f"{word.text[:40]} of global_settings is lost")
                read.colour()

    def _default(self) -> None:
        """#default { texture { ... } } and so on."""
        stream = self._stream
        for word in stream.block(stream.peek()):
            if word.text == "texture":
                texture = self._textures.texture(word)
            else:
                texture = self._textures.repainted((self._textures.usual,), word)
            if len(texture) != 1 or not hasattr(texture[0], "finish"):
                raise word.error("#default of a checkerboard of textures; allowed are a pigment and a finish")
            self._textures.usual = texture[0]  # pyright: ignore[reportAttributeAccessIssue]

    def _declared(self) -> Any:
        """The value of a #declare."""
        stream, token = self._stream, self._stream.peek()
        readers = {
            "texture": self._textures.layers,
            "pigment": self._textures.pigment,
            "finish": self._textures.finish,
            "interior": self._textures.interior,
            "transform": self._read.transform,
        }
        if token.kind == "text":
            return stream.take().text
        if token.text in readers and token.kind == "word":
            return readers[token.text](stream.take())
        if token.kind == "word" and self._objects.begins(token):
            return self._objects.read(stream.take()) or LEFT
        if token.text in ("camera", "light_source", "normal", "material", "color_map", "colour_map", "media"):
            raise token.error(
                f"#declare of {token.text} is not read; allowed are numbers, vectors, colours, pigments, finishes, "
                "textures, interiors, transforms and shapes"
            )
        value = stream.values.get(token.text)
        if isinstance(value, (Pigment, Finish, Interior, tuple, str)) or value is LEFT:
            stream.take()
            return value
        return self._read.expression()


def _ends(sky: Sky, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """The colours straight down and straight up of a gradient over all heights, if it is one of two colours."""
    if len(sky.stops) != 2 or (sky.axis != (0, 1, 0)).any():
        return None
    (first, low), (last, high) = sky.stops
    height = (matrix @ sky.matrix)[1]
    straight = np.allclose([height[0], height[2]], 0) and np.allclose(
        height[1] * np.asarray([first, last]) + height[3], [-1, 1]
    )
    return (low[:3], high[:3]) if straight else None
