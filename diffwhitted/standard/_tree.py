"""Tree: cones and spheres that branch."""

from collections.abc import Iterator
from math import radians

import numpy as np

from ..scene import AbstractObject, Cone, Polygon, SphereSet
from ._parts import Parts, X, Z, paint, turned, usual_camera, usual_scene

BASE_RADIUS, TAPER = 0.15, 0.67
BRANCHES = ((40, 90, 0.65), (25, 230, 0.70))
"""Of each child: degrees about x, then about z, and its length in that of its parent."""
LIGHTS = ((-5, 5, 50), (30, -30, 30), (-40, -30, 20), (10, 30, 40), (-30, 40, 10), (50, 25, 20), (-10, -60, 30))
FIELD = ((50, 50, 0), (-50, 50, 0), (-50, -50, 0), (50, -50, 0))


def tree(size: int) -> Parts:
    """2^(size + 1) - 1 branches on a field, each a cone with a sphere at its tip."""
    grown = list(branches(size))
    objects: list[AbstractObject] = [
        Cone(f"branch {number}", base, tip, radius, TAPER * radius, "bark", capped=False)
        for number, (base, tip, radius) in enumerate(grown, 1)
    ]
    radii = TAPER * np.asarray([radius for *_, radius in grown])
    objects.append(SphereSet("tips", [tip for _, tip, _ in grown], radii, "bark"))
    objects.append(Polygon("field", FIELD, "grass"))
    return usual_scene(
        objects,
        {"bark": paint((0.55, 0.4, 0.2), 1.0), "grass": paint((0.2, 0.7, 0.2), 1.0)},
        LIGHTS,
        usual_camera((4.5, 0.4, 2), (0, 0, 1.5)),
    )


def branches(size: int) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
    """Base (3,), tip (3,) and base radius of each branch, metres, level by level."""
    level, radius = [(np.zeros(3), np.eye(3))], BASE_RADIUS
    ways = [scale * turned(X, radians(tilt)) @ turned(Z, radians(turn)) for tilt, turn, scale in BRANCHES]
    for _ in range(size + 1):
        yield from ((base, base + axes[2], radius) for base, axes in level)
        level = [(base + axes[2], way @ axes) for base, axes in level for way in ways]
        radius *= TAPER
