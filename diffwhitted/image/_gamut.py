"""From other primaries to those of Rec.709: one 3 x 3 matrix, Bradford-adapted, white to white.

All matrices come from the colour-science package.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from ._colour import PRIMARIES, colour_science
from ._faults import Unusable

_SAME = 2e-3
"""Chromaticities nearer than this are the same: writers round them."""


def from_chromaticities(chromaticities: Sequence[float]) -> Float[np.ndarray, "3 3"] | None:
    """The matrix from RGB with these x, y of red, green, blue and white to Rec.709; None where it is Rec.709.

    Raises Unusable for chromaticities that span no colours: a white outside the triangle of the primaries, or none.
    """
    values = np.asarray(chromaticities, np.float64)
    if np.allclose(values, PRIMARIES, rtol=0, atol=_SAME):
        return None
    xy = values.reshape(4, 2)
    weights = _weights(xy)
    if weights is None:
        listed = ", ".join(f"{value:.4g}" for value in values)
        raise Unusable(f"its chromaticities are {listed}, whose white is no mixture of red, green and blue")
    colour = colour_science()
    to_xyz = colour.normalised_primary_matrix(xy[:3], xy[3])
    return from_xyz_columns(to_xyz)


def _weights(xy: Float[np.ndarray, "4 2"]) -> Float[np.ndarray, "3"] | None:
    """White as a mixture of the three primaries in the (x, y) plane; None unless all shares are positive."""
    points = np.concatenate([xy, np.ones((4, 1))], axis=1)
    if not np.isfinite(points).all() or abs(np.linalg.det(points[:3])) < 1e-6 or not xy[3, 1] > 0:
        return None
    weights = np.linalg.solve(points[:3].T, points[3])
    return weights if (weights > 0).all() else None


def from_xyz_columns(to_xyz: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "3 3"]:
    """The matrix from RGB to Rec.709, given the X, Y, Z (rows) of red, green and blue (columns).

    White is the sum of the columns; it is taken to Rec.709's (1, 1, 1) by Bradford's adaptation (Lam 1985).
    """
    colour = colour_science()
    rec709 = colour.models.RGB_COLOURSPACE_BT709
    to_rec709 = np.linalg.inv(colour.normalised_primary_matrix(rec709.primaries, rec709.whitepoint))
    white = np.linalg.solve(to_rec709, np.ones(3))
    adapted = colour.adaptation.matrix_chromatic_adaptation_VonKries(to_xyz.sum(axis=1), white, transform="Bradford")
    return to_rec709 @ adapted @ to_xyz


def from_space(name: str) -> Float[np.ndarray, "3 3"] | None:
    """The matrix to Rec.709 from a colour space by its name in colour-science."""
    space = colour_science().RGB_COLOURSPACES[name]
    return from_chromaticities([*space.primaries.ravel(), *space.whitepoint])
