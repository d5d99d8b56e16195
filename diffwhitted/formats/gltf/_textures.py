"""Checkerboards of glTF: a picture of two by two pixels that repeats, and coordinates at the corners of the meshes."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...image._colour import encode_srgb
from ...scene import Checker, Scene
from .._losses import Losses, named
from .._meshes import checker_coordinates
from .._numbers import plain
from ._buffer import picture

NEAREST, REPEAT = 9728, 10497


class Textures:
    """The pictures of a file, and which material wears which checkerboard."""

    def __init__(self):
        self._worn: dict[str, Checker] = {}
        self._pictures: list[tuple[str, str]] = []

    def dress(
        self, made: dict[str, Any], base: np.ndarray, scene: Scene, name: str, meshes: Sequence[np.ndarray],
        lost: Losses,
    ) -> None:  # fmt: skip
        """Give a material, as far as it is made, the checkerboard of its k_d; `meshes`: points of all that wears it."""
        what = ("material", name)
        for coefficient, pattern in scene.materials[name].textures:
            checker = scene.textures[pattern]
            if coefficient != "k_d" or not isinstance(checker, Checker):
                lost.say(f"texture {named(pattern)} of {coefficient} of {{}} is lost", what)
                continue
            two = plain(checker.colours)
            if any(checker_coordinates(checker, points) is None for points in meshes):
                lost.say(f"texture {named(pattern)} of {{}} is its mean colour, as it changes along three axes", what)
                shade = base * two.mean(axis=0)
            else:
                # A picture goes to 1; the factor of the material takes the rest.
                peak = max(float(two.max()), 1e-9)
                made["baseColorTexture"] = {"index": len(self._pictures)}
                codes = np.rint(255 * encode_srgb(two[[[0, 1], [1, 0]]] / peak))
                self._pictures.append((pattern, picture(codes)))
                self._worn[name] = checker
                lost.say(f"the colours of texture {named(pattern)} are to 8 bits")
                shade = base * peak
            if (shade > 1).any():
                lost.say("the base colour of {} is limited to 1", what)
            made["baseColorFactor"] = [*np.clip(shade, 0, 1).tolist(), 1.0]

    def coordinates(self, material: str, points: np.ndarray) -> np.ndarray | None:
        """Those of a mesh of a material; None where it wears no checkerboard."""
        checker = self._worn.get(material)
        if checker is None:
            return None
        found = checker_coordinates(checker, points)
        # Whole periods are taken off, so that float32 keeps the digits.
        return None if found is None else found - np.floor(found.min(axis=0))

    def lists(self) -> dict[str, list]:
        """What the file holds of them."""
        if not self._pictures:
            return {}
        sampler = {"magFilter": NEAREST, "minFilter": NEAREST, "wrapS": REPEAT, "wrapT": REPEAT}
        return {
            "textures": [{"name": name, "sampler": 0, "source": k} for k, (name, _) in enumerate(self._pictures)],
            "images": [{"name": name, "uri": uri} for name, uri in self._pictures],
            "samplers": [sampler],
        }
