"""Mappings: from a point of a surface to coordinates u, v of a picture; v = 0 is its bottom row, u = 0 its left edge.

planar       P = origin + u edge_u + v edge_v, of the part of P - origin in their plane
spherical    u = angle / 2 pi about +y from -z towards +x, v = 1/2 + latitude / pi, seen from the centre
cylindrical  the same u, v = 1/2 + (P - centre).y / height
triplanar    (-z, y), (x, -z) and (x, y) over the size, along x, y and z; weights N_x^2, N_y^2, N_z^2
"""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...numerics._safe import safe_divide, safe_sqrt
from ...numerics._vector import Vec3, dot, vec3
from ._texture import TexturePoint

UV = tuple[Float[Array, "*n"], Float[Array, "*n"]]
Mapping = Callable[[TexturePoint], UV]
Keys = dict[str, Any]
"""The numbers of a mapping, by name."""


def own_uv(keys: Keys) -> list[Mapping]:
    """The coordinates that the object brings along."""
    del keys

    def uv(point: TexturePoint) -> UV:
        assert point.uv is not None, "the scene refuses such a texture on objects without coordinates"
        return point.uv

    return [uv]


def planar(keys: Keys) -> list[Mapping]:
    """By the dual basis of the two edges."""
    origin, across, up = vec3(keys["origin"]), vec3(keys["edge_u"]), vec3(keys["edge_v"])
    uu, uv, vv = dot(across, across), dot(across, up), dot(up, up)
    area = uu * vv - uv * uv
    dual_u = across * safe_divide(vv, area) - up * safe_divide(uv, area)
    dual_v = up * safe_divide(uu, area) - across * safe_divide(uv, area)

    def coordinates(point: TexturePoint) -> UV:
        away = point.position - origin
        return dot(away, dual_u), dot(away, dual_v)

    return [coordinates]


def spherical(keys: Keys) -> list[Mapping]:
    """Edge: on the axis u = 0 with derivative 0, in the centre v = 1/2 with derivative 0."""
    centre = vec3(keys["centre"])

    def coordinates(point: TexturePoint) -> UV:
        away = point.position - centre
        beside = safe_sqrt(away.x * away.x + away.z * away.z)
        there = (beside > 0) | (away.y != 0)
        latitude = jnp.arctan2(jnp.where(there, away.y, 0), jnp.where(there, beside, 1))
        return _turn(away), 0.5 + latitude / jnp.pi

    return [coordinates]


def cylindrical(keys: Keys) -> list[Mapping]:
    """Edge: on the axis u = 0 with derivative 0."""
    centre = vec3(keys["centre"])

    def coordinates(point: TexturePoint) -> UV:
        away = point.position - centre
        return _turn(away), 0.5 + away.y / keys["height"]

    return [coordinates]


def triplanar(keys: Keys) -> list[Mapping]:
    """One for each axis along which the picture is laid on."""
    corner = vec3(keys["corner"])

    def along(u: str, v: str, sign_u: int = 1, sign_v: int = 1):
        def coordinates(point: TexturePoint) -> UV:
            away = point.position - corner
            return sign_u * getattr(away, u) / keys["size"], sign_v * getattr(away, v) / keys["size"]

        return coordinates

    return [along("z", "y", -1), along("x", "z", 1, -1), along("x", "y")]


MAPPINGS: dict[str, tuple[Callable[[Keys], list[Mapping]], Keys]] = {
    "uv": (own_uv, {}),
    "planar": (planar, {"origin": (0.0, 0.0, 0.0), "edge_u": (1.0, 0.0, 0.0), "edge_v": (0.0, 1.0, 0.0)}),
    "spherical": (spherical, {"centre": (0.0, 0.0, 0.0)}),
    "cylindrical": (cylindrical, {"centre": (0.0, 0.0, 0.0), "height": 1.0}),
    "triplanar": (triplanar, {"size": 1.0}),
}
"""By name: the mapping, and its keys with what they are where they are not stated."""


def blend(normal: Vec3) -> tuple[Float[Array, "*n"], ...]:
    """The weights of the three planes of `triplanar`; 1 in all."""
    return normal.x * normal.x, normal.y * normal.y, normal.z * normal.z


def _turn(away: Vec3) -> Float[Array, "*n"]:
    """The angle about +y from -z towards +x, as a part of the whole turn from 0 to 1."""
    there = (away.x != 0) | (away.z != 0)
    part = jnp.arctan2(jnp.where(there, away.x, 0), jnp.where(there, -away.z, 1)) / (2 * jnp.pi)
    return jnp.where(part < 0, part + 1, part)
