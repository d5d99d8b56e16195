"""Shapes in POV-Ray's words, as they are read: a function a kind."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..others import _placed as placed
from ..others._placed import Maker
from ._coats import Texture
from ._expressions import Expressions
from ._stream import Stream
from ._tokens import Token

MOST_POINTS = 20_000_000
MeshPart = tuple[np.ndarray, np.ndarray, np.ndarray | None]
"""Points (n, 3), triangles (m, 3), and normals (n, 3) or None."""


@dataclass(eq=False)
class Shape:
    """A shape, or a union of others, in its own frame."""

    kind: str
    token: Token
    makers: tuple[Callable[[np.ndarray], Maker], ...] = ()
    """Each gives an object for the matrix (4, 4) of where it stands."""
    children: tuple["Shape", ...] = ()
    ball: tuple[np.ndarray, float] | None = None
    """Centre and radius of a sphere."""
    numbers: Any = None
    """Of a quadric that may be clipped, its coefficients."""
    matrix: Any = None
    texture: Texture | None = None
    index: float | None = None
    shadowless: bool = False
    unseen: bool = False
    spot: tuple[str, int] | None = None
    texture_name: str | None = None

    def __post_init__(self):
        self.matrix = np.eye(4) if self.matrix is None else self.matrix


class Shapes:
    """Reads the numbers with which a shape begins; the modifiers are left."""

    def __init__(self, stream: Stream, expressions: Expressions):
        self._stream, self._read = stream, expressions

    def begin(self, token: Token) -> Shape:
        """After the word of the shape and its brace."""
        return BEGINNINGS[token.text](self, token)

    def vector(self, of: Token) -> np.ndarray:
        found = self._read.vector(of.text)
        self._stream.comma()
        return found

    def number(self, of: Token) -> float:
        found = self._read.number(of.text)
        self._stream.comma()
        return found

    def count(self, of: Token) -> int:
        token, found = self._stream.peek(), self.number(of)
        if not (found.is_integer() and 0 <= found <= MOST_POINTS):
            raise token.error(f"{found:g} in {of.text}; allowed is a whole number up to {MOST_POINTS:,}")
        return int(found)

    def has(self, word: str) -> bool:
        return self._stream.accept(word) is not None

    def sphere(self, of: Token) -> Shape:
        centre, radius = self.vector(of), self.number(of)
        return Shape("sphere", of, (lambda m: placed.sphere(m, centre, radius),), ball=(centre, radius))

    def plane(self, of: Token) -> Shape:
        normal, offset = self.vector(of), self.number(of)
        size = np.linalg.norm(normal)
        if not size > 0:
            raise of.error("a plane without a normal; allowed is one other than <0,0,0>")
        return Shape("plane", of, (lambda m: placed.plane(m, normal / size, offset),))

    def box(self, of: Token) -> Shape:
        low, high = self.vector(of), self.vector(of)
        return Shape("box", of, (lambda m: placed.box(m, low, high),))

    def cylinder(self, of: Token) -> Shape:
        base, top, radius = self.vector(of), self.vector(of), self.number(of)
        return self._frustum("cylinder", of, base, top, radius, radius)

    def cone(self, of: Token) -> Shape:
        base, low, top, high = self.vector(of), self.number(of), self.vector(of), self.number(of)
        return self._frustum("cone", of, base, top, low, high)

    def _frustum(self, kind: str, of: Token, base, top, low: float, high: float) -> Shape:
        capped = not self.has("open")
        if not np.linalg.norm(top - base) > 0:
            raise of.error(f"a {kind} without a length; allowed are two ends apart")
        return Shape(kind, of, (lambda m: placed.frustum(m, base, top, low, high, capped),))

    def torus(self, of: Token) -> Shape:
        major, minor = self.number(of), self.number(of)
        return Shape("torus", of, (lambda m: placed.torus(m, (0, 0, 0), (0, 1, 0), major, minor),))

    def disc(self, of: Token) -> Shape:
        centre, normal, radius = self.vector(of), self.vector(of), self.number(of)
        if self._stream.peek().kind == "number":
            hole = self.number(of)
            if hole:
                raise of.error("a disc with a hole is not read; allowed is one without")
        return Shape("disc", of, (lambda m: placed.disc(m, centre, normal, radius),))

    def triangle(self, of: Token) -> Shape:
        corners = np.stack([self.vector(of) for _ in range(3)])
        return Shape("triangle", of, (lambda m: placed.polygon(m, corners),))

    def smooth_triangle(self, of: Token) -> Shape:
        table = np.stack([self.vector(of) for _ in range(6)])
        return self._meshes("mesh", of, [(table[::2], np.asarray([[0, 1, 2]]), table[1::2])])

    def polygon(self, of: Token) -> Shape:
        """The first of its outlines, which is closed by its first corner."""
        count = self.count(of)
        if not 3 <= count <= 10_000:
            raise of.error(f"a polygon of {count} corners; allowed is 3 to 10,000")
        corners = np.stack([self.vector(of) for _ in range(count)])
        again = np.flatnonzero((corners[1:] == corners[0]).all(axis=1))
        end = int(again[0]) + 1 if len(again) else count
        if end < count - 1:
            raise of.error("a polygon of more than one outline is not read; allowed is one, without holes")
        outline = corners[:end]
        return Shape("polygon", of, (lambda m: placed.polygon(m, outline),))

    def quadric(self, of: Token) -> Shape:
        parts = [self.vector(of) for _ in range(3)]
        numbers = np.asarray([*np.concatenate(parts), self.number(of)])
        return Shape("quadric", of, (lambda m: placed.quadric(m, numbers),), numbers=numbers)

    def mesh(self, of: Token) -> Shape:
        """Triangles, of which those with normals are a mesh of their own."""
        flat, smooth, stream = [], [], self._stream
        while word := stream.accept("triangle", "smooth_triangle"):
            stream.expect("{", word.text)
            count = 3 if word.text == "triangle" else 6
            (flat if count == 3 else smooth).extend(self.vector(word) for _ in range(count))
            if stream.accept("texture"):
                raise word.error("textures of single triangles are not read; allowed is one of the whole mesh")
            stream.expect("}", word.text)
        self._inside(of)
        parts: list[MeshPart] = []
        if flat:
            parts.append((np.stack(flat), np.arange(len(flat)).reshape(-1, 3), None))
        if smooth:
            table = np.stack(smooth)
            parts.append((table[::2], np.arange(len(table) // 2).reshape(-1, 3), table[1::2]))
        return self._meshes("mesh", of, parts)

    def mesh2(self, of: Token) -> Shape:
        """Lists of points, normals and triangles."""
        stream, found = self._stream, {}
        while word := stream.accept("vertex_vectors", "normal_vectors", "face_indices", "uv_vectors", "normal_indices"):
            stream.expect("{", word.text)
            flat, rows = word.text == "uv_vectors", []
            for _ in range(self.count(word)):
                rows.append(self._read.expression() if flat else self.vector(word))
                stream.comma()
                if word.text == "face_indices" and stream.peek().kind == "number":
                    raise stream.peek().error("textures of single triangles are not read; allowed is one of the mesh")
            stream.expect("}", word.text)
            found[word.text] = rows
        self._inside(of)
        for key in ("vertex_vectors", "face_indices"):
            if not found.get(key):
                raise of.error(f"a mesh2 without {key}")
        points, normals = np.stack(found["vertex_vectors"]), found.get("normal_vectors")
        faces = np.stack(found["face_indices"]).astype(np.int64)
        if normals is not None:
            table, own = np.stack(normals), np.stack(found.get("normal_indices", faces)).astype(np.int64)
            self._check_faces(of, own, len(table), len(faces))
            if not np.array_equal(own, faces):
                self._check_faces(of, faces, len(points), len(faces))
                points, faces = points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
                normals = table[own].reshape(-1, 3)
            elif len(table) != len(points):
                raise of.error(f"{len(table)} normals and {len(points)} points; allowed is as many")
            else:
                normals = table
        self._check_faces(of, faces, len(points), len(faces))
        return self._meshes("mesh", of, [(points, faces, normals)])

    def _check_faces(self, of: Token, faces: np.ndarray, points: int, count: int) -> None:
        if faces.shape != (count, 3) or faces.min() < 0 or faces.max() >= points:
            raise of.error(f"a triangle of a mesh2 names a point that is not there; there are {points}, from 0")

    def _inside(self, of: Token) -> None:
        if self._stream.accept("inside_vector"):
            self.vector(of)

    def _meshes(self, kind: str, of: Token, parts: list[MeshPart]) -> Shape:
        if not parts:
            raise of.error("a mesh without a triangle; allowed is one or more")
        return Shape(kind, of, tuple(_mesh(*part) for part in parts))


def _mesh(points: np.ndarray, faces: np.ndarray, normals: np.ndarray | None) -> Callable[[np.ndarray], Maker]:
    """Triangles face as their normals do, or out of the mesh; POV-Ray does not ask."""

    def made(matrix: np.ndarray) -> Maker:
        a, b, c = (points[faces[:, k]] - points.mean(axis=0) for k in range(3))
        across = np.cross(b - a, c - a)
        if normals is None:
            inwards = np.full(len(faces), float(np.einsum("fk,fk->", a, across)) < 0)
        else:
            inwards = np.einsum("fk,fk->f", normals[faces].sum(axis=1), across) < 0
        # `placed.mesh` turns those of a mirrored transform, so that what faced outwards does.
        return placed.mesh(matrix, points, np.where(inwards[:, None], faces[:, ::-1], faces), normals)

    return made


BEGINNINGS: dict[str, Callable[[Shapes, Token], Shape]] = {
    "sphere": Shapes.sphere,
    "plane": Shapes.plane,
    "box": Shapes.box,
    "cylinder": Shapes.cylinder,
    "cone": Shapes.cone,
    "torus": Shapes.torus,
    "disc": Shapes.disc,
    "triangle": Shapes.triangle,
    "smooth_triangle": Shapes.smooth_triangle,
    "polygon": Shapes.polygon,
    "quadric": Shapes.quadric,
    "mesh": Shapes.mesh,
    "mesh2": Shapes.mesh2,
}
UNIONS = ("union", "merge", "object")
LEFT_OUT = (
    "difference", "intersection", "blob", "bicubic_patch", "height_field", "isosurface", "julia_fractal", "lathe",
    "parametric", "prism", "sphere_sweep", "superellipsoid", "sor", "text", "poly", "cubic", "quartic", "polynomial",
    "ovus",
)  # fmt: skip
