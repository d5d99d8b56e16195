"""What an NFF file has of each material, and the objects that are made of it."""

from array import array
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._errors import SceneError
from ..scene import AbstractObject, Cone, Cylinder, Material, Mesh, SphereSet

MOST_FRUSTA = 100_000
"""Each is an object of its own."""


@dataclass
class Faces:
    """Polygons one after the other: the numbers of all corners, and how many corners each has."""

    columns: int
    numbers: array = field(default_factory=lambda: array("d"))
    counts: array = field(default_factory=lambda: array("i"))

    def add(self, corners: np.ndarray) -> None:
        self.numbers.frombytes(np.ascontiguousarray(corners[:, : self.columns], np.float64).tobytes())
        self.counts.append(len(corners))

    def arrays(self) -> tuple[np.ndarray, Any]:
        """(corners, columns), and the faces: an array where all have as many corners, else lists."""
        table = np.frombuffer(self.numbers, np.float64).reshape(-1, self.columns)
        counts = np.frombuffer(self.counts, np.int32)
        if (counts == counts[0]).all():
            return table, np.arange(len(table)).reshape(len(counts), -1)
        ends = np.cumsum(counts)
        return table, [list(range(end - count, end)) for end, count in zip(ends.tolist(), counts.tolist(), strict=True)]


@dataclass
class Fill:
    """One material, and what is made of it."""

    name: str
    material: Material
    spheres: array = field(default_factory=lambda: array("d"))
    """x, y, z, radius of each."""
    polygons: Faces = field(default_factory=lambda: Faces(3))
    patches: Faces = field(default_factory=lambda: Faces(6))
    frusta: list[AbstractObject] = field(default_factory=list)


class Things:
    """All materials of a file, each once, in the order in which they come."""

    def __init__(self, source: str):
        self._source = source
        self._fills: dict[tuple[float, ...], Fill] = {}
        self._frusta = 0

    def fill(self, numbers: tuple[float, ...], material: Material) -> Fill:
        """The material of these numbers: the one that is there, or a new one."""
        if numbers not in self._fills:
            self._fills[numbers] = Fill(f"fill_{len(self._fills) + 1}", material)
        return self._fills[numbers]

    def frustum(self, place: str, fill: Fill, base, top, low: float, high: float) -> None:
        """Add a cone, or a cylinder where both radii are one; open."""
        self._frusta += 1
        if self._frusta > MOST_FRUSTA:
            raise SceneError(f"{place}: more than {MOST_FRUSTA:,} cones and cylinders; allowed is fewer")
        if low == high:
            made = Cylinder(f"cylinder_{self._frusta}", base, top, low, fill.name, capped=False, place=place)
        else:
            made = Cone(f"cone_{self._frusta}", base, top, low, high, fill.name, capped=False, place=place)
        fill.frusta.append(made)

    def made(self) -> tuple[list[AbstractObject], dict[str, Material]]:
        """The objects, and the materials by name. Raises `SceneError` where there is no object."""
        objects: list[AbstractObject] = []
        for number, fill in enumerate(self._fills.values(), 1):
            place = f"{self._source}: material {fill.name}"
            if fill.spheres:
                table = np.frombuffer(fill.spheres, np.float64).reshape(-1, 4)
                objects.append(SphereSet(f"spheres_{number}", table[:, :3], table[:, 3], fill.name))
            if fill.polygons.counts:
                vertices, faces = fill.polygons.arrays()
                name = f"polygons_{number}"
                objects.append(Mesh(name, vertices, faces, fill.name, shading="flat", place=f"{place}: its polygons"))
            if fill.patches.counts:
                table, faces = fill.patches.arrays()
                name, about = f"patches_{number}", f"{place}: its patches"
                objects.append(Mesh(name, table[:, :3], faces, fill.name, normals=table[:, 3:], place=about))
            objects += fill.frusta
        if not objects:
            raise SceneError(f"{self._source}: there is nothing in it to be seen; allowed is s, p, pp and c after an f")
        return objects, {fill.name: fill.material for fill in self._fills.values()}
