"""Pigments, finishes, textures and interiors in POV-Ray's words, as they are read."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .._losses import Losses
from ._coats import MOST_LEAVES, Layer, Pigment, Texture, Tiles, leaves, moved
from ._expressions import Expressions
from ._stream import Stream
from ._tokens import Token

USUAL: dict[str, Any] = {
    "ambient": np.full(3, 0.1), "diffuse": 0.6, "phong": 0.0, "phong_size": 40.0, "specular": 0.0, "roughness": 0.05,
    "reflection": np.zeros(3), "fresnel": False, "conserve": False,
}  # fmt: skip
PATTERNS = (
    "gradient", "image_map", "granite", "bozo", "marble", "wood", "agate", "crackle", "leopard", "onion", "ripples",
    "waves", "wrinkles", "brick", "hexagon", "spotted", "dents", "bumps", "radial", "spiral1", "spiral2", "cells",
    "facets", "boxed", "cylindrical", "planar", "spherical", "average", "mandel", "julia", "quilted", "function",
    "slope", "density_file", "object", "square", "triangular", "pigment_pattern", "aoi", "cubic", "tiling", "magnet",
)  # fmt: skip
MAPS = ("color_map", "colour_map", "pigment_map", "texture_map", "slope_map", "normal_map")
TRANSFORMS = ("translate", "rotate", "scale", "matrix", "transform")


@dataclass(frozen=True, eq=False)
class Sky:
    """The colours of a gradient along an axis, by their places, and where it lies."""

    axis: np.ndarray
    stops: tuple[tuple[float, np.ndarray], ...]
    matrix: np.ndarray


@dataclass(frozen=True)
class Interior:
    """The index of a medium."""

    index: float = 1.0


@dataclass(frozen=True, eq=False)
class Finish:
    """By the keys of `USUAL`."""

    values: dict[str, Any] = field(default_factory=lambda: dict(USUAL))


class Textures:
    """Reads them from a stream."""

    def __init__(self, stream: Stream, expressions: Expressions, lost: Losses):
        self._stream, self._read, self._lost = stream, expressions, lost
        self.usual = Layer(Pigment((np.zeros(5),)), dict(USUAL))
        self.declared: str | None = None
        """The name under which the texture was declared that was read last."""

    def texture(self, token: Token, base: Texture | None = None) -> Texture:
        """After the word `texture`. `base`: what it changes."""
        stream, lost = self._stream, self._lost
        found: Texture = base or (self.usual,)
        self.declared = None
        for word in stream.block(token):
            matrix = self._read.transform(word) if word.text in TRANSFORMS else None
            value = stream.values.get(word.text)
            if matrix is not None:
                found = moved(found, matrix)
            elif isinstance(value, tuple):
                found, self.declared = value, word.text
            elif word.text == "pigment":
                found = (*found[:-1], self._repainted(found[-1], word))
            elif word.text == "finish":
                found = (*found[:-1], self._repainted(found[-1], word))
            elif word.text == "checker":
                first = self._halves(word)
                stream.comma()
                found = (Tiles(first, self._halves(word), np.eye(4)),)
            elif word.text == "normal" or word.text in MAPS or word.text == "interior_texture":
                lost.say(f"{word.text} is lost")
                stream.skip_block(word)
            elif word.text in PATTERNS:
                lost.say(f"a texture of the pattern {word.text} is lost")
                self._skip_pattern()
            else:
                raise word.error(f"{word.said()} in a texture; allowed are pigment, finish, checker and transforms")
            if leaves(found) > MOST_LEAVES:
                raise word.error(f"a texture of more than {MOST_LEAVES} layers and patterns; allowed is fewer")
        return found

    def layers(self, token: Token) -> Texture:
        """Textures one after the other, of which `token` begins the first."""
        found = self.texture(token)
        while following := self._stream.accept_here("texture"):
            found = (*found, *self.texture(following))
            if leaves(found) > MOST_LEAVES:
                raise following.error(f"more than {MOST_LEAVES} layers of a texture; allowed is fewer")
        return found

    def repainted(self, texture: Texture, token: Token) -> Texture:
        """After `pigment` or `finish` of a shape: its highest layer with another."""
        return (*texture[:-1], self._repainted(texture[-1], token))

    def _repainted(self, layer: Layer | Tiles, token: Token) -> Layer:
        """What is not stated stays."""
        if not isinstance(layer, Layer):
            raise token.error(f"{token.text} of a checkerboard of textures; allowed is one within each of them")
        if token.text == "pigment":
            return replace(layer, pigment=self.pattern(token, layer.pigment)[0])
        return replace(layer, finish=self.finish(token, layer.finish).values)

    def _halves(self, token: Token) -> Texture:
        first = self._stream.take()
        if first.text != "texture":
            raise first.error(f"{first.said()} after checker in a texture; allowed is texture {{...}}, twice")
        return self.layers(first)

    def pigment(self, token: Token) -> Pigment:
        """After the word `pigment`; of a pattern that is not known its mean colour."""
        return self.pattern(token)[0]

    def pattern(self, token: Token, base: Pigment | None = None) -> tuple[Pigment, Sky | None]:
        """The pigment, and the gradient if it is one. `base`: what it changes."""
        stream, read, lost = self._stream, self._read, self._lost
        found, axis, stops, matrix, other = base or self.usual.pigment, None, (), np.eye(4), None
        for word in stream.block(token):
            step = read.transform(word) if word.text in TRANSFORMS else None
            if step is not None:
                found, matrix = found.moved(step), step @ matrix
            elif isinstance(stream.values.get(word.text), Pigment):
                found = stream.values[word.text]
            elif word.text == "checker":
                found = Pigment(self._two(), np.eye(4))
            elif word.text == "gradient":
                axis, other = read.vector("gradient"), word.text
            elif word.text in ("color_map", "colour_map"):
                stops = self._stops(word)
            elif word.text in PATTERNS:
                other = word.text
                self._skip_pattern()
            elif word.text in MAPS:
                lost.say(f"{word.text} is lost")
                stream.skip_block(word)
            elif word.text == "quick_color" or word.text == "quick_colour":
                read.colour()
            elif word.text in ("uv_mapping", "warp", "turbulence", "frequency", "phase", "octaves", "omega", "lambda"):
                self._skip_pattern()
            else:
                stream.give_back(word)
                found = Pigment((read.colour(),))
        sky = None if axis is None else Sky(axis, stops, matrix)
        if other is not None:
            mean = np.mean([colour for _, colour in stops], axis=0) if stops else np.asarray([0.5, 0.5, 0.5, 0, 0])
            found = Pigment((mean,))
            if sky is None or token.text == "pigment":
                self.gradient_lost(other)
        return found, sky

    def gradient_lost(self, pattern: str) -> None:
        self._lost.say(f"a pigment of the pattern {pattern} is lost: it is its mean colour, or grey")

    def _two(self) -> tuple[np.ndarray, np.ndarray]:
        """The colours of a checkerboard; blue and green where none is stated."""
        stream, found = self._stream, []
        for usual in ((0, 0, 1, 0, 0), (0, 1, 0, 0, 0)):
            stream.comma()
            if stream.peek().text == "}" or stream.peek().text in TRANSFORMS:
                found.append(np.asarray(usual, float))
            elif word := stream.accept("pigment"):
                inner = self.pigment(word)
                if inner.matrix is not None:
                    self._lost.say("a checkerboard within a checkerboard of pigments is its mean colour")
                found.append(np.mean(inner.colours, axis=0))
            else:
                found.append(self._read.colour())
        return found[0], found[1]

    def _stops(self, token: Token) -> tuple[tuple[float, np.ndarray], ...]:
        stream, found = self._stream, []
        for mark in stream.block(token):
            if mark.text != "[":
                raise mark.error(f"{mark.said()} in a color_map; allowed is [place colour]")
            places = [self._read.number("[")]
            stream.comma()
            if stream.peek().kind == "number":
                places.append(self._read.number("["))
                stream.comma()
            colours = [self._read.colour() for _ in places]
            stream.expect("]", "a color_map")
            found += zip(places, colours, strict=True)
            if len(found) > MOST_LEAVES:
                raise mark.error(f"a color_map of more than {MOST_LEAVES} colours; allowed is fewer")
        return tuple(found)

    def _skip_pattern(self) -> None:
        """Leave out what belongs to a pattern: numbers, words that are not known, and braces."""
        stream = self._stream
        while True:
            token = stream.peek()
            if token.text in ("}", "pigment", "finish", "normal", "texture", *TRANSFORMS, *MAPS) or token.kind == "end":
                return
            if token.text == "{":
                stream.skip_block(token)
            else:
                stream.take()

    def finish(self, token: Token, base: dict[str, Any] | None = None) -> Finish:
        """After the word `finish`. `base`: what it changes."""
        stream, read, lost = self._stream, self._read, self._lost
        found = dict(base or self.usual.finish)
        for word in stream.block(token):
            key, value = word.text, stream.values.get(word.text)
            if isinstance(value, Finish):
                found = dict(value.values)
            elif key == "ambient":
                found[key] = read.colour()[:3]
            elif key == "emission":
                lost.say("emission is ambient light, which is as strong where ambient_light is 1")
                found["ambient"] = found["ambient"] + read.colour()[:3]
            elif key == "reflection":
                found[key], found["fresnel"] = self._reflection(word)
            elif key in ("diffuse", "phong", "phong_size", "specular", "roughness"):
                if stream.accept("albedo"):
                    lost.say("albedo is lost: amounts of highlights are taken as they are")
                found[key] = self._amount(word)
                if stream.accept(","):
                    read.number(key)
                    lost.say("diffuse light of the other side is lost")
            elif key == "conserve_energy":
                found["conserve"] = self._switch()
            elif key in ("brilliance", "crand", "metallic", "irid", "subsurface", "fresnel", "use_alpha"):
                lost.say(f"{key} of a finish is lost")
                self._skip_value(word)
            else:
                raise word.error(
                    f"{word.said()} in a finish; allowed are ambient, diffuse, phong, phong_size, specular, roughness "
                    "and reflection"
                )
        return Finish(found)

    def _amount(self, token: Token) -> float:
        found = self._read.number(token.text)
        if found < 0 or (token.text == "roughness" and found == 0):
            raise token.error(f"{token.text} {found:g}; allowed is {'> 0' if token.text == 'roughness' else '>= 0'}")
        return found

    def _switch(self) -> bool:
        """A word for on or off, if there is one; else on."""
        word = self._stream.accept("on", "off", "yes", "no", "true", "false")
        return word is None or word.text in ("on", "yes", "true")

    def _reflection(self, token: Token) -> tuple[np.ndarray, bool]:
        """The colour, and whether Fresnel's share of it is mirrored."""
        stream, read, fresnel = self._stream, self._read, False
        if stream.peek().text != "{":
            return read.colour()[:3], False
        colours = []
        for word in stream.block(token):
            if word.text == "fresnel":
                fresnel = self._switch()
            elif word.text in ("falloff", "exponent", "metallic"):
                self._lost.say(f"{word.text} of reflection is lost")
                self._skip_value(word)
            elif word.text != ",":
                stream.give_back(word)
                colours.append(read.colour()[:3])
        if len(colours) > 1 and (not fresnel or colours[0].any()):
            self._lost.say("reflection that depends on the angle is what it is at its most")
            fresnel = False
        return (colours[-1] if colours else np.zeros(3)), fresnel

    def _skip_value(self, token: Token) -> None:
        """A number, a word for on or off, or braces, if there are any."""
        stream = self._stream
        if stream.peek().text == "{":
            stream.skip_block(token)
        elif stream.peek().kind == "number" or stream.peek().text in ("on", "off", "yes", "no", "-", "("):
            self._read.expression()

    def interior(self, token: Token) -> Interior:
        """After the word `interior`."""
        stream, found = self._stream, 1.0
        for word in stream.block(token):
            value = stream.values.get(word.text)
            if isinstance(value, Interior):
                found = value.index
            elif word.text == "ior":
                found = self._read.number("ior")
                if found < 1:
                    self._lost.say("an ior below 1 is taken for 1")
                    found = 1.0
            elif word.text == "media":
                self._lost.say("media is lost")
                stream.skip_block(word)
            else:
                self._lost.say(f"{word.text[:40]} of an interior is lost")
                if stream.peek().text != "}":
                    self._read.colour()
        return Interior(found)
