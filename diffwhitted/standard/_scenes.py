"""The one list of standard scenes. A new one is a function in a file here, and one line."""

from .._errors import SceneError
from ..scene import Precision, Scene, nearest_name
from ._balls import balls
from ._cornell import cornell
from ._figure_7 import figure_7
from ._gears import gears
from ._mount import mount
from ._parts import StandardScene
from ._rings import rings
from ._table import table
from ._teapot import teapot
from ._tetra import tetra
from ._tree import tree

STANDARD: dict[str, StandardScene] = {
    "balls": StandardScene(balls, 4, 6, "Haines: a flake of (9^(N + 1) - 1) / 8 spheres over a floor"),
    "gears": StandardScene(gears, 4, 8, "Haines: N^3 interlocking gears, some of glass, over a floor"),
    "mount": StandardScene(mount, 6, 10, "Haines: a mountain of 2 * 4^N triangles and four balls of glass"),
    "rings": StandardScene(rings, 7, 12, "Haines: N layers of interlaced rings of cylinders and spheres"),
    "teapot": StandardScene(teapot, 12, 100, "Haines: Newell's teapot, N x N cells a patch, over a checkered floor"),
    "tetra": StandardScene(tetra, 6, 10, "Haines: Sierpinski's tetrahedron of 4^N triangles"),
    "tree": StandardScene(tree, 11, 14, "Haines: a tree of 2^(N + 1) - 1 branches, cones and spheres"),
    "figure_7": StandardScene(figure_7, 12, 1000, "Whitted 1980: a glass ball and a small one over N squares"),
    "cornell": StandardScene(cornell, 1, 2, "the Cornell box; N = 2: its tall block is a mirror"),
    "table": StandardScene(table, 64, 2000, "glass on a table: a tumbler of N steps around, balls"),
}
"""By name."""


def standard_scene(name: str, size: int | None = None, *, precision: Precision = "float32") -> Scene:
    """A scene that many have rendered: Haines' databases, Whitted's figure, the Cornell box, a table with glass.

    `name` is one of `diffwhitted.standard.STANDARD`; `size` says how much there is of it (see `about` there), its usual
    size unless stated; `precision` is that of every array of the scene. Haines' scenes have z up, the others y. Raises
    `SceneError` for a name that is none, and a size below 1 or above what is held in memory.
    """
    if name not in STANDARD:
        raise SceneError(
            f"no standard scene is called {name!r}; there is {', '.join(STANDARD)}.{nearest_name(name, STANDARD)}"
        )
    entry = STANDARD[name]
    size = entry.size if size is None else size
    if isinstance(size, bool) or not isinstance(size, int) or not 1 <= size <= entry.largest:
        raise SceneError(
            f"standard scene {name!r}: size = {size!r}; allowed is a whole number from 1 to {entry.largest}, "
            f"usual is {entry.size} ({entry.about})"
        )
    return Scene(**entry.make(size), precision=precision)
