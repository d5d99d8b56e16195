"""Textures of POV-Ray as coefficients: the reverse of `_materials`.

A layer of a pigment P with the shares f (filter) and t (transmit) sends back (1 - f - t) P of diffuse and ambient light
and lets f P + t through, which multiplies what comes from the layers below.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..._errors import SceneError
from .._losses import Losses
from ..others._boards import Board, board_of
from ..others._found import Paint

MOST_PATTERNS = 6
MOST_LEAVES = 256
"""Of one texture, all its layers and patterns together."""
COLOURED = ("k_a", "k_d", "k_h", "k_s", "k_t")


@dataclass(frozen=True, eq=False)
class Pigment:
    """One colour (5,), or two of a checkerboard that a matrix (4, 4) puts into the scene."""

    colours: tuple[np.ndarray, ...]
    matrix: np.ndarray | None = None

    def moved(self, matrix: np.ndarray) -> "Pigment":
        return self if self.matrix is None else replace(self, matrix=matrix @ self.matrix)


@dataclass(frozen=True, eq=False)
class Layer:
    """A pigment and a finish."""

    pigment: Pigment
    finish: dict[str, Any]
    leaves: int = 1

    def moved(self, matrix: np.ndarray) -> "Layer":
        return self if self.pigment.matrix is None else replace(self, pigment=self.pigment.moved(matrix))


@dataclass(frozen=True, eq=False)
class Tiles:
    """A checkerboard of two textures, each its layers from the lowest up."""

    first: tuple["Layer | Tiles", ...]
    second: tuple["Layer | Tiles", ...]
    matrix: np.ndarray

    @property
    def leaves(self) -> int:
        return 1 + sum(layer.leaves for layer in (*self.first, *self.second))

    def moved(self, matrix: np.ndarray) -> "Tiles":
        return Tiles(moved(self.first, matrix), moved(self.second, matrix), matrix @ self.matrix)


Texture = tuple[Layer | Tiles, ...]
"""Layers from the lowest up."""


def moved(texture: Texture, matrix: np.ndarray) -> Texture:
    """The same where a transform takes it: itself, if it has no pattern."""
    there = tuple(layer.moved(matrix) for layer in texture)
    return texture if all(a is b for a, b in zip(there, texture, strict=True)) else there


def leaves(texture: Texture) -> int:
    return sum(layer.leaves for layer in texture)


Tree = dict[str, Any] | tuple[np.ndarray, Any, Any]
"""Coefficients; or a checkerboard's matrix, and the trees of its two colours."""


def paint_of(texture: Texture, matrix: np.ndarray, index: float, name: str, lost: Losses, place: str) -> Paint:
    """The material of a texture where `matrix` (4, 4) puts it. Raises `SceneError` that begins with the place."""
    if _patterns(texture) > MOST_PATTERNS:
        raise SceneError(f"{place}: a texture of more than {MOST_PATTERNS} patterns; allowed is fewer")
    tree = _tree(moved(texture, matrix))
    what = ("material", name)
    boards: dict[str, Board] = {}
    coefficients: dict[str, Any] = {"refractive_index": index}
    for coefficient in COLOURED:
        value, found = _collapsed(tree, coefficient, lambda sentence: lost.say(sentence, what))
        if found is not None:
            where, colours = found
            board = board_of(colours, where)
            if board is None:
                lost.say("a checkerboard of {} that is turned or stretched is its mean colour", what)
            else:
                boards[coefficient] = board
        coefficients[coefficient] = value
    shines = [leaf for leaf in _leaves(tree) if leaf["k_h"].any()]
    exponents = {leaf["exponent"] for leaf in shines}
    models = {leaf["highlight"] for leaf in shines}
    if len(exponents) > 1 or len(models) > 1:
        lost.say("highlights of {} of more than one kind are those of the first", what)
    coefficients["phong_exponent"] = shines[0]["exponent"] if shines else 50.0
    fresnel = index > 1 and any(leaf["fresnel"] for leaf in _leaves(tree))
    if fresnel and coefficients["k_t"].any() and not all(leaf["conserve"] for leaf in _leaves(tree)):
        lost.say("without conserve_energy the transmitted light of {} is k_t; here it is 1 - F k_s of it", what)
    highlight = shines[0]["highlight"] if shines else "halfway"
    return Paint(coefficients, highlight, boards, "exact" if fresnel else "off")


def _patterns(texture: Texture) -> int:
    """How many of them decide on one point, at most."""
    halves = [max(_patterns(layer.first), _patterns(layer.second)) for layer in texture if isinstance(layer, Tiles)]
    own = [1 for layer in texture if isinstance(layer, Tiles) or layer.pigment.matrix is not None]
    return sum(halves) + len(own)


def _tree(texture: Texture) -> Tree:
    """One board after the other is decided on."""
    for k, layer in enumerate(texture):
        if isinstance(layer, Tiles):
            first, second = (_tree((*texture[:k], *half, *texture[k + 1 :])) for half in (layer.first, layer.second))
            return layer.matrix, first, second
        if layer.pigment.matrix is not None:
            halves = (replace(layer, pigment=Pigment((colour,))) for colour in layer.pigment.colours)
            first, second = (_tree((*texture[:k], half, *texture[k + 1 :])) for half in halves)
            return layer.pigment.matrix, first, second
    return _coat([layer for layer in texture if isinstance(layer, Layer)])


def _coat(layers: list[Layer]) -> dict[str, Any]:
    """The coefficients of layers, from the lowest up."""
    found: dict[str, Any] = {name: np.zeros(3) for name in COLOURED}
    found |= {"exponent": 50.0, "highlight": "halfway", "fresnel": False, "conserve": False}
    above = np.ones(3)
    for layer in reversed(layers):
        (colour,), finish = layer.pigment.colours, layer.finish
        sent = above * (1 - min(1.0, colour[3] + colour[4])) * colour[:3]
        found["k_a"] = found["k_a"] + sent * finish["ambient"]
        found["k_d"] = found["k_d"] + sent * finish["diffuse"]
        found["k_s"] = found["k_s"] + above * finish["reflection"]
        found["fresnel"] |= finish["fresnel"]
        found["conserve"] |= finish["conserve"]
        amount, model, exponent = finish["phong"], "reflected", finish["phong_size"]
        if not amount:
            amount, model, exponent = finish["specular"], "halfway", 1 / finish["roughness"]
        if amount:
            if not found["k_h"].any():
                found["highlight"], found["exponent"] = model, exponent
            found["k_h"] = found["k_h"] + above * amount
        above = above * (colour[:3] * colour[3] + colour[4])
    return found | {"k_t": above}


def _leaves(tree: Tree) -> list[dict[str, Any]]:
    return [tree] if isinstance(tree, dict) else [*_leaves(tree[1]), *_leaves(tree[2])]


def _collapsed(tree: Tree, name: str, say: Callable[[str], None]):
    """One coefficient (3,), and the matrix and the two colours (2, 3) of the board that it varies with, or None."""
    if isinstance(tree, dict):
        return tree[name], None
    (one, board_1), (other, board_2) = (_collapsed(half, name, say) for half in tree[1:])
    if board_1 is None and board_2 is None:
        if np.allclose(one, other, rtol=1e-9, atol=1e-12):
            return one, None
        colours = np.stack([one, other])
        return colours.mean(axis=0), (tree[0], colours)
    if board_1 is not None and board_2 is not None:
        alike = [np.allclose(a, b, rtol=1e-9, atol=1e-12) for a, b in zip(board_1, board_2, strict=True)]
        if all(alike):
            return one, board_1
    say(f"{name} of {{}} varies with more than one pattern, and is its mean")
    return (one + other) / 2, None
