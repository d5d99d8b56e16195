"""Objects in POV-Ray's words: a shape and what modifies it, and what becomes of it in a scene."""

from dataclasses import dataclass, replace

import numpy as np

from ...scene import Box, SphereSet
from .._losses import Losses
from ..others import _placed as placed
from ..others._found import Found
from ..others._placed import at, check, even_growth
from ._coats import Texture, moved, paint_of
from ._expressions import Expressions
from ._shapes import BEGINNINGS, LEFT_OUT, UNIONS, Shape, Shapes
from ._stream import Stream
from ._textures import TRANSFORMS, Textures
from ._tokens import Token

MOST_PARTS = 1_000_000
SILENT = ("sturm", "hollow", "hierarchy", "split_union", "double_illuminate", "radiosity")
"""What changes nothing of a picture here."""
SWITCHES = ("on", "off", "yes", "no", "true", "false")


class Objects:
    """Reads them from a stream, and adds them to what was found."""

    def __init__(self, stream: Stream, expressions: Expressions, textures: Textures, lost: Losses):
        self._stream, self._read, self._textures, self._lost = stream, expressions, textures, lost
        self._shapes = Shapes(stream, expressions)
        self._worn_before: dict[tuple[int, int, float], tuple[Texture, str]] = {}
        self._parts = 0

    def begins(self, token: Token) -> bool:
        """Is this the word of an object?"""
        return token.text in BEGINNINGS or token.text in UNIONS or token.text in LEFT_OUT

    def read(self, token: Token) -> Shape | None:
        """After the word of the object: the object, None for one that is left out."""
        stream = self._stream
        if token.text in LEFT_OUT:
            self._lost.say(f"left out: {token.text}")
            stream.skip_block(token)
            return None
        stream.expect("{", token.text)
        with stream.deeper(token):
            if token.text in UNIONS:
                found = self._union(token)
            else:
                found = self._shapes.begin(token)
            while not stream.accept("}"):
                self._modify(found, stream.take())
        found.spot = stream.spot()
        return found

    def _union(self, token: Token) -> Shape:
        """The objects within it, or the one that was declared."""
        stream, children = self._stream, []
        if token.text == "merge":
            self._lost.say("the inner surfaces of a merge are there, as those of a union")
        while True:
            word = stream.peek()
            declared = stream.values.get(word.text)
            if isinstance(declared, Shape):
                stream.take()
                children.append(declared)
            elif declared is LEFT:
                stream.take()
            elif word.kind == "word" and self.begins(word):
                stream.take()
                if (one := self.read(word)) is not None:
                    children.append(one)
            elif word.text == "light_source":
                raise word.error("light_source in a union is not read; allowed is one of its own")
            elif not children and token.text == "object" and word.text != "}":
                raise word.error(f"{word.said()} is no object; is it declared above?")
            else:
                return Shape(token.text, token, children=tuple(children))

    def _modify(self, shape: Shape, word: Token) -> None:
        stream, lost = self._stream, self._lost
        if word.kind == "end":
            raise shape.token.error(f"{shape.token.text} {{ has no end; allowed is a }} for each {{")
        if word.text in TRANSFORMS:
            matrix = self._read.transform(word)
            if matrix is None:
                raise word.error(f"{word.said()} is no transform")
            check(matrix, word.place)
            shape.matrix = matrix @ shape.matrix
            shape.texture = None if shape.texture is None else moved(shape.texture, matrix)
        elif word.text == "texture":
            shape.texture = self._textures.layers(word)
            shape.texture_name = self._textures.declared
        elif word.text in ("pigment", "finish"):
            base: Texture = shape.texture or (self._textures.usual,)
            shape.texture = self._textures.repainted(base, word)
        elif word.text == "interior":
            shape.index = self._textures.interior(word).index
        elif word.text == "material":
            self._material(shape, word)
        elif word.text in ("no_shadow", "no_image", "no_reflection"):
            shape.shadowless |= word.text == "no_shadow"
            shape.unseen |= word.text == "no_image"
            if word.text == "no_reflection" and not shape.unseen:
                lost.say("no_reflection is lost")
        elif word.text == "clipped_by":
            self._clip(shape, word)
        elif word.text == "bounded_by":
            stream.skip_block(word)
        elif word.text in SILENT:
            stream.accept(*SWITCHES)
        elif word.text in ("normal", "photons", "uv_mapping", "interior_texture"):
            lost.say(f"{word.text} is lost")
            if stream.peek().text == "{":
                stream.skip_block(word)
        elif word.text == "inverse":
            lost.say("inverse is lost")
        else:
            raise word.error(
                f"{word.said()} in {shape.token.text}; allowed are texture, pigment, finish, interior and transforms"
            )

    def _material(self, shape: Shape, token: Token) -> None:
        for word in self._stream.block(token):
            if word.text == "texture":
                shape.texture = self._textures.layers(word)
                shape.texture_name = self._textures.declared
            elif word.text == "interior":
                shape.index = self._textures.interior(word).index
            else:
                raise word.error(f"{word.said()} in a material; allowed are texture and interior")

    def _clip(self, shape: Shape, token: Token) -> None:
        """A quadric may be cut off by a box of its own frame."""
        stream = self._stream
        stream.expect("{", token.text)
        clip = self.read(stream.take()) if self.begins(stream.peek()) else None
        if clip is None:
            raise token.error("clipped_by without a shape that is read; allowed is a box, of a quadric")
        stream.expect("}", token.text)
        made = clip.makers[0](clip.matrix)("box", "") if clip.kind == "box" else None
        if shape.numbers is None or not isinstance(made, Box) or not np.array_equal(shape.matrix, np.eye(4)):
            self._lost.say(f"clipped_by of a {shape.kind} is lost")
            return
        numbers, low, high = shape.numbers, np.asarray(made.minimum, float), np.asarray(made.maximum, float)
        shape.makers = (lambda m: placed.quadric(m, numbers, low, high),)

    def add(self, shape: Shape, found: Found, flip: np.ndarray) -> None:
        """All objects of a shape. `flip` (4, 4) takes POV-Ray's axes to ours."""
        self._add(shape, found, _Above(flip, name=self._said(shape)))

    def _add(self, shape: Shape, found: Found, above: "_Above") -> None:
        self._parts += 1
        if self._parts > MOST_PARTS:
            raise shape.token.error(f"more than {MOST_PARTS:,} parts of unions; allowed is fewer")
        here = replace(above, matrix=above.matrix @ shape.matrix, name=above.name or self._said(shape))
        if shape.texture is not None:
            here = replace(here, texture=moved(shape.texture, above.matrix), texture_name=shape.texture_name)
        if shape.index is not None:
            here = replace(here, index=shape.index)
        check(here.matrix, shape.token.place)
        if len(shape.children) > 1 and all(_is_plain_ball(child) for child in shape.children):
            return self._add_spheres(shape, found, here)
        for child in shape.children:
            self._add(child, found, here)
        if shape.makers:
            material = self._worn(shape, here, found)
            for make in shape.makers:
                found.add(make(here.matrix), here.name, shape.kind, material, shape.token.place)

    def _said(self, shape: Shape) -> str | None:
        """What a comment calls it."""
        return None if shape.spot is None else self._stream.remarks.names.get(shape.spot)

    def _worn(self, shape: Shape, here: "_Above", found: Found) -> str:
        """The name of the material; that of a texture that was met before is known."""
        stream, texture = self._stream, here.texture or (self._textures.usual,)
        known = self._worn_before.get((id(texture[0]), len(texture), here.index))
        if known is not None and known[0] == texture:
            return known[1]
        declared = here.texture_name
        spot = None if declared is None else stream.spots.get(declared)
        name = declared if spot is None else stream.remarks.names.get(spot, declared)
        said = name or f"of line {shape.token.line}"
        paint = paint_of(texture, np.eye(4), here.index, said, self._lost, shape.token.place)
        if not paint.coefficients["k_t"].any() and paint.fresnel == "off":
            paint = replace(paint, coefficients=paint.coefficients | {"refractive_index": 1.0})
        made = found.material(paint, name or shape.kind)
        self._worn_before[id(texture[0]), len(texture), here.index] = texture, made
        return made

    def _add_spheres(self, shape: Shape, found: Found, here: "_Above") -> None:
        """One set of spheres, where all of them stay round."""
        balls = [(here.matrix @ child.matrix, child, *child.ball) for child in shape.children if child.ball is not None]
        growths = [even_growth(matrix) for matrix, *_ in balls]
        material = self._worn(shape, here, found)
        if None in growths:
            for matrix, child, _, _ in balls:
                found.add(child.makers[0](matrix), here.name, "sphere", material, child.token.place)
            return
        centres = np.stack([at(matrix, centre) for matrix, _, centre, _ in balls])
        radii = np.asarray(growths) * [radius for *_, radius in balls]
        found.add(
            lambda name, worn: SphereSet(name, centres, radii, worn), here.name, "spheres", material, shape.token.place
        )


@dataclass(frozen=True, eq=False)
class _Above:
    """What a union hands down."""

    matrix: np.ndarray
    texture: Texture | None = None
    texture_name: str | None = None
    index: float = 1.0
    name: str | None = None


def _is_plain_ball(shape: Shape) -> bool:
    return shape.ball is not None and shape.texture is None and shape.index is None


class _Left:
    """In place of a declared object that is left out."""


LEFT = _Left()
