"""Light between the corners of a triangle in other ways than Phong's: Gouraud's, and by a series of the normal.

Both are for lamps alone: mirrors and glass see Phong's interpolated normal whatever the shading. Whether a lamp reaches
a point is asked pixel by pixel. Where shadows are cast, one that the interpolated normal is turned away from does not.
"""

from collections.abc import Callable
from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ..geometry import Corners, corners_at
from ..illumination import SurfacePoint, Terms, lit
from ..numerics._safe import normalise
from ..numerics._stage import stage
from ..numerics._vector import Vec3, lookup, where
from ..scene import AbstractLight, Tables
from ..shapes import SHADING
from ._arrival import Arrival
from ._plan import Plan


class Interpolation(eqx.Module):
    """Where rays arrived on triangles, and how light is interpolated there."""

    corners: Corners
    gouraud: Bool[Array, "n"] | None
    """The light at the corners is; None where no object of the scene is shaded so."""
    series: Bool[Array, "n"] | None
    """Lamps see the series of the normal; in the same way."""
    normal: Vec3
    """The interpolated one."""
    shadows: bool = eqx.field(static=True)

    def seen_by_lights(self, point: SurfacePoint) -> SurfacePoint:
        """The point with the series of its normal in place of the normal, where it is shaded so."""
        if self.series is None:
            return point
        return replace(point, shading_normal=where(self.series, self.corners.near_normal(), point.shading_normal))

    def interpolated(
        self,
        ask: Callable,
        light: AbstractLight,
        terms: Terms,
        colour: Vec3,
        point: SurfacePoint,
        to_light: Vec3,
        needed,
    ) -> tuple[Terms, Vec3]:
        """The terms of a light, and the colour that they are to be multiplied by.

        `ask(point, to_light, needed)`: the terms of the light at a point.
        """
        terms = self._at_most_one(terms)
        if self.gouraud is not None:
            terms, colour = self._between_corners(ask, light, terms, colour, point, needed)
        if not self.shadows:
            return terms, colour
        # Leave out lamps behind the interpolated normal.
        special = self.gouraud if self.series is None else self.series
        special = special if self.gouraud is None or self.series is None else self.gouraud | self.series
        reaches = jnp.where(special, lit(self.normal, to_light), 1)
        return terms, colour * reaches

    def _at_most_one(self, terms: Terms) -> Terms:
        """No cosine exceeds 1, whatever a series that was broken off makes of it; there its derivative is 0."""
        if self.series is None or terms.diffuse is None:
            return terms
        return replace(terms, diffuse=jnp.where(self.series, jnp.minimum(terms.diffuse, 1), terms.diffuse))

    def _between_corners(
        self, ask: Callable, light: AbstractLight, terms: Terms, colour: Vec3, point: SurfacePoint, needed
    ) -> tuple[Terms, Vec3]:
        """Terms times colour at the three corners by the shares of the point (Hearn and Baker 14-38, 14-39), and white.

        A corner is seen from where the ray set out.
        """

        def at_corners(point: SurfacePoint) -> tuple[Vec3 | None, Vec3 | None]:
            origin, sums = point.position - point.incoming * point.distance, [None, None]
            for place, normal, share in zip(
                self.corners.places, self.corners.normals, self.corners.shares, strict=True
            ):
                incoming = normalise(place - origin)
                corner = replace(point, position=place, shading_normal=normal, incoming=incoming)
                towards, _, arriving = light.arriving(place)
                found = ask(corner, towards, needed)
                arriving = arriving * share
                highlight = None if found.lit is None or found.lobe is None else found.lit * found.lobe
                for number, factor in enumerate((found.diffuse, highlight)):
                    if factor is not None:
                        part = arriving * factor
                        sums[number] = part if sums[number] is None else sums[number] + part
            return tuple(sums)

        diffuse, highlight = stage(needed & self.gouraud.any(), at_corners, point)
        one = jnp.ones_like(point.position.x)

        def mixed(between, value):
            return None if between is None else where(self.gouraud, between, colour * value)

        here = None if terms.lit is None or terms.lobe is None else terms.lit * terms.lobe
        before = None if terms.lit is None else one
        return Terms(mixed(diffuse, terms.diffuse), before, mixed(highlight, here)), Vec3(one, one, one)


def interpolation(tables: Tables, plan: Plan, at: Arrival) -> Interpolation:
    """How light is interpolated where rays arrived, by the objects that they met."""
    shading, effects = lookup(tables.shading, jnp.maximum(at.object, 0)), plan.effects
    return Interpolation(
        corners_at(tables.shapes, at.primitive, at.point, at.entering),
        (shading == SHADING.index("gouraud")) & (at.object >= 0) if effects.gouraud else None,
        (shading == SHADING.index("fast_phong")) & (at.object >= 0) if effects.fast_phong else None,
        at.shading_normal,
        effects.shadows,
    )
