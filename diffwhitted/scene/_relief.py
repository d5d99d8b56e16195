"""What bends the normals of a material: a texture of heights or one of normals (Blinn 1978)."""

from collections.abc import Iterable, Mapping
from pathlib import PurePath
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Int

from .._errors import SceneError
from ..records import is_traced
from ..shapes import AbstractObject
from .textures import AbstractTexture, ImageTexture

RELIEFS: dict[str, str] = {
    "height_texture": "Name of a texture of heights, by whose slopes normals are bent; height_scale says how high.",
    "normal_texture": "Name of an image texture of normals: 2 c - 1 along +u, +v and outwards.",
}
"""The keys, and what they mean."""
LINEAR_FILES = (".exr", ".hdr", ".pfm")
"""Their numbers stand for themselves."""


class Relief(eqx.Module):
    """Which textures bend the normals of which materials."""

    texture: dict[str, Int[Array, "materials"]]
    """By the key: the number of the texture, -1 for none."""
    groups: tuple[tuple[str, int], ...] = eqx.field(static=True)
    """(key, number of a group of stacked textures), of those of which some texture is worn so."""


def read_relief(stated: dict[str, Any], height_scale, place: str) -> tuple[tuple[str, str], ...]:
    """(key, name of the texture), of the keys that are stated. Raises `SceneError` for those that do not go together.

    `height_scale`: as it is stated, or None.
    """
    found = tuple((key, stated[key]) for key in RELIEFS if stated.get(key) is not None)
    if len(found) > 1:
        raise SceneError(f"{place}: {found[0][0]} and {found[1][0]} are both stated; leave one of them out")
    key = found[0][0] if found else None
    some = height_scale is not None and (is_traced(height_scale) or np.any(np.asarray(height_scale) != 0))
    if key == "height_texture" and height_scale is None:
        raise SceneError(
            f"{place}: height_texture is stated, and no height_scale: the height of a texture of 1, metres; write one, "
            "such as a tenth of the size of a bump"
        )
    if key != "height_texture" and some:
        raise SceneError(
            f"{place}: height_scale is stated, and no height_texture, which it would scale; write one"
            + (", or leave it out: a normal_texture says how steep it is" if key else ", or leave it out")
        )
    return found


def check_relief(
    materials: Mapping[str, Any], textures: Mapping[str, AbstractTexture], objects: Iterable[AbstractObject]
) -> None:
    """Raise `SceneError` for a texture that has no slopes, or no normals, and for shading that does not see them."""
    wearing = {name: material.relief[0] for name, material in materials.items() if material.relief}
    for name, (key, texture) in wearing.items():
        place = f"material {name!r}: {key} = {texture!r}"
        _check_texture(key, textures[texture], place)
    for thing in objects if wearing else ():
        if thing.material in wearing and thing.interpolation in ("gouraud", "fast_phong"):
            raise SceneError(
                f"object {thing.name!r}: shading = {thing.interpolation!r}, by which lamps do not see the normals that "
                f'{wearing[thing.material][0]} of material {thing.material!r} bends; write shading = "phong" or "flat"'
            )


def _check_texture(key: str, worn: AbstractTexture, place: str) -> None:
    if key == "normal_texture" and not isinstance(worn, ImageTexture):
        raise SceneError(f"{place} is of type {worn.TYPE!r}; allowed is an image; for a pattern write height_texture")
    if not worn.SLOPED:
        raise SceneError(
            f"{place} is of type {worn.TYPE!r}, which has steps and no slopes; allowed is noise, waves, dimples or an "
            "image"
        )
    if not isinstance(worn, ImageTexture):
        return
    coded = worn.file is not None and worn.encoding is None
    if coded and PurePath(str(worn.file)).suffix.lower() not in LINEAR_FILES:
        raise SceneError(
            f"{place}: the texture states no encoding, and a file such as {worn.file!r} would be decoded as colours; "
            'write encoding = "linear" where its numbers are heights or normals'
        )
    if key == "normal_texture" and not is_traced(worn.texels):
        blue = np.asarray(worn.texels)[..., 2]
        if not (blue > 0.5).all():
            row, column = (int(k) for k in np.argwhere(blue <= 0.5)[0])
            raise SceneError(
                f"{place}: the texel in row {row}, column {column} (from 0, top left) has blue = "
                f"{float(blue[row, column]):.4g}, a normal into the surface; allowed is > 0.5. Is it a picture of "
                'normals, read with encoding = "linear"?'
            )
