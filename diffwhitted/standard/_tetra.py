"""Tetra: Sierpinski's tetrahedron."""

import numpy as np

from ..scene import Mesh
from ._parts import Parts, paint, usual_camera, usual_scene

CORNERS = np.asarray([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]], np.float64)
"""Of a cube, those four whose coordinates have a positive product."""
FACES = np.asarray([[0, 1, 3], [0, 2, 1], [0, 3, 2], [1, 2, 3]])
"""Counter-clockwise seen from outside."""


def tetra(size: int) -> Parts:
    """4^size triangles of one colour."""
    return usual_scene(
        [Mesh("tetra", *sierpinski(size), "tetra")],
        {"tetra": paint((1, 0.2, 0.2), 1.0)},
        [(2, -18, -5)],
        usual_camera(
            (1.022846, -3.177154, -2.174512), (-0.004103, -0.004103, 0.216539), (-0.816497, -0.816497, 0.816497)
        ),
    )


def sierpinski(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (4 t, 3) and faces (4 t, 3) of t = 4^(size - 1) tetrahedra."""
    centres, half = np.zeros((1, 3)), 1.0
    for _ in range(size - 1):
        half /= 2
        centres = (centres[:, None] + half * CORNERS).reshape(-1, 3)
    vertices = (centres[:, None] + half * CORNERS).reshape(-1, 3)
    return vertices, (4 * np.arange(len(centres))[:, None, None] + FACES).reshape(-1, 3)
