"""The Cornell box, by the measured places of its corners (www.graphics.cornell.edu/online/box/data.html), in metres.

Whitted's model has no light between diffuse surfaces: in place of the square lamp there is a point below it, and a
constant ambient light in place of what the walls send.
"""

import numpy as np

from ..scene import AbstractObject, Camera, Material, Mesh, PointLight, Polyhedron
from ._parts import Parts

PER_METRE = 100
"""The data are about a box of 55 cm in millimetres; here it is a room of 5.5 m."""
WALLS = {
    "floor": ("white", ((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))),
    "ceiling": ("white", ((556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0))),
    "back": ("white", ((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2))),
    "right": ("green", ((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))),
    "left": ("red", ((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0))),
}
"""Materials and corners, counter-clockwise seen from within, as the data have them. Those of the left wall lie in no
plane."""
BLOCKS = {
    "short block": (165, ((130, 65), (82, 225), (240, 272), (290, 114))),
    "tall block": (330, ((423, 247), (265, 296), (314, 456), (472, 406))),
}
"""Height, and corners of the top (x, z)."""
REFLECTANCES = {"white": (0.73, 0.73, 0.73), "red": (0.57, 0.04, 0.04), "green": (0.11, 0.43, 0.12)}
"""The walls' measured spectra as linear RGB, roughly."""


def cornell(size: int) -> Parts:
    """`size` 1: two white blocks; 2: the tall one is a mirror."""
    objects: list[AbstractObject] = [
        Mesh(name, np.asarray(corners) / PER_METRE, [[0, 1, 2, 3]], colour) for name, (colour, corners) in WALLS.items()
    ]
    for name, (height, corners) in BLOCKS.items():
        material = "mirror" if size > 1 and name == "tall block" else "white"
        objects.append(Polyhedron(name, *_block(height, corners), material))
    materials = {name: Material(k_a=colour, k_d=colour) for name, colour in REFLECTANCES.items()}
    if size > 1:
        materials["mirror"] = Material(k_a=0.05, k_d=0.05, k_s=0.85)
    return dict(
        objects=objects,
        materials=materials,
        lights=[PointLight((2.78, 5.3, 2.795), (0.85, 0.72, 0.5), name="lamp")],
        cameras={"main": Camera((2.78, 2.73, -8), (2.78, 2.73, 0), 39.31, 480, 480)},
        ambient=(0.16, 0.14, 0.1),
        max_depth=4,
    )


def _block(height: float, corners) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices (8, 3) and faces of an upright block; `corners` run counter-clockwise seen from above."""
    top = np.asarray([[x, height, z] for x, z in corners]) / PER_METRE
    sides = [[k, k + 4, (k + 1) % 4 + 4, (k + 1) % 4] for k in range(4)]
    return np.concatenate([top, top * [1, 0, 1]]), [[0, 1, 2, 3], [7, 6, 5, 4], *sides]
