"""Patches: the surfaces of a scene cut into small polygons, each on the side from which others can see it.

Light is gathered at sites, the corners of the grids that patches are cut by, and interpolated between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from .._errors import SceneError
from ..shapes import AbstractObject
from ._faces import Face, faces_of
from ._lambert import area_of, centres_of, cut, padded, radii_of, spread

INSET = 1e-3
"""Sites lie so far within the border of their face, as a share of the way to its middle."""
SLIVER = 1e-6
"""A part of a cell smaller than this share of it is left out."""
LEVEL = 1e-6
"""What rises above a plane by less than this share of the scene's size lies in it."""
ON_IT = 1e-4
"""A place that is so near to the surface of a body, as a share of its way from the middle, lies on it."""
MOST_PATCHES = 6000
FINER = 4
"""The area of a round patch is that of so many parts along each side."""
SAMPLES = 16
"""Points of a patch to which rays are sent."""


@dataclass(frozen=True, eq=False)
class Chart:
    """The grid of one side of a face: where its sites are."""

    face: Face
    inner: bool
    cells: tuple[int, int]
    """0, 0: one patch with one site."""
    first: int
    """Its first site."""

    @property
    def sites(self) -> int:
        return (self.cells[0] + 1) * (self.cells[1] + 1)


@dataclass(frozen=True, eq=False)
class Places:
    """Points of surfaces."""

    position: Float[np.ndarray, "n *q 3"]
    normal: Float[np.ndarray, "n *q 3"]
    """Unit, on the side that is looked at."""
    chart: Int[np.ndarray, "n"]


@dataclass(frozen=True, eq=False)
class Patches:
    """All patches of a scene."""

    loops: Float[np.ndarray, "n v 3"]
    """Corners, counter-clockwise seen from the side that sees others."""
    centre: Float[np.ndarray, "n 3"]
    normal: Float[np.ndarray, "n 3"]
    area: Float[np.ndarray, "n"]
    radius: Float[np.ndarray, "n"]
    chart: Int[np.ndarray, "n"]
    charts: tuple[Chart, ...]
    sites: Places
    samples: Places
    """`SAMPLES` of each patch, on the surface itself."""

    @property
    def count(self) -> int:
        return len(self.area)

    @property
    def object(self) -> Int[np.ndarray, "n"]:
        return self.of_chart([chart.face.object for chart in self.charts])

    @property
    def round(self) -> Bool[np.ndarray, "n"]:
        return self.of_chart([chart.face.frame is not None for chart in self.charts])

    @property
    def inner(self) -> Bool[np.ndarray, "n"]:
        return self.of_chart([chart.inner for chart in self.charts])

    def of_chart(self, values: Sequence) -> np.ndarray:
        return np.asarray(values)[self.chart]

    def on_surface(self, points: Float[np.ndarray, "n q 3"]) -> Places:
        """Points of each patch moved onto its surface."""
        position, normal = points.copy(), np.repeat(self.normal[:, None], points.shape[1], axis=1)
        for number in np.unique(self.object[self.round]):
            mine = self.object == number
            face = self.charts[self.chart[mine][0]].face
            at, out = face.outwards(points[mine].reshape(-1, 3))
            position[mine] = at.reshape(points[mine].shape)
            normal[mine] = out.reshape(points[mine].shape) * np.where(self.inner[mine], -1, 1)[:, None, None]
        return Places(position, normal, self.chart)


def patches_of(
    objects: Sequence[AbstractObject], wanted: int, others: Float[np.ndarray, "m 3"] | None = None
) -> Patches:
    """About so many patches of objects, all about as large. `others`: places of lamps and cameras.

    Of a face the sides count before which another object, a lamp or a camera lies; else the outer one. Raises
    `SceneError` for a kind of object that has no patches, and where there would be more than `MOST_PATCHES`.
    """
    others = np.zeros((0, 3)) if others is None else others
    if not objects:
        raise SceneError("radiosity: there is no object, so there are no patches; give the scene a surface")
    faces = [faces_of(thing, number) for number, thing in enumerate(objects)]
    sides = [(face, inner) for face, inner in _sides(objects, faces, others)]
    lengths = [face.lengths() for face, _ in sides]
    areas = np.asarray([face.area() for face, _ in sides])
    width = _width(areas, lengths, wanted)
    charts, loops, owner, sites, first = [], [], [], [], 0
    for number, ((face, inner), (long, wide)) in enumerate(zip(sides, lengths, strict=True)):
        cells = _cells(long, width), _cells(wide, width)
        parts = _parts(face, *cells)
        if len(loops) + len(parts) > MOST_PATCHES:
            size = MOST_PATCHES**2 * 8 / 2**20
            raise SceneError(
                f"radiosity: more than {MOST_PATCHES} patches; allowed are so many, whose form factors take {size:.0f} "
                f"MiB several times over. Lower patches (it is {wanted}), or give meshes fewer triangles"
            )
        uv = _site_places(face, *((0, 0) if cells == (1, 1) else cells))
        charts.append(Chart(face, inner, (0, 0) if cells == (1, 1) else cells, first))
        position, normal = face.at(uv)
        sites.append((position, -normal if inner else normal, np.full(len(uv), number)))
        first += len(uv)
        loops += [part[::-1] if inner else part for part in parts]
        owner += [number] * len(parts)
    chart, all_loops = np.asarray(owner), padded(loops)
    centre, normal, flat = centres_of(all_loops)
    area = np.concatenate([_areas(charts[k], flat[chart == k]) for k in range(len(charts))])
    found = Patches(
        all_loops, centre, normal, area, radii_of(all_loops, centre), chart, tuple(charts),
        Places(*map(np.concatenate, zip(*sites, strict=True))), Places(centre, normal, chart),
    )  # fmt: skip
    samples = found.on_surface(spread(all_loops, SAMPLES))
    return replace(found, samples=samples)


def _cells(length: float, width: float) -> int:
    return max(1, int(np.ceil(length / width - 1e-6)))


def _width(areas, lengths, wanted: int) -> float:
    """The width of cells of which there are at least so many."""

    def count(width):
        cells = np.asarray([_cells(one, width) * _cells(other, width) for one, other in lengths])
        filled = areas / np.asarray([one * other for one, other in lengths])
        return np.maximum(1, cells * filled).sum()

    high = max(max(pair) for pair in lengths)
    low = high
    while count(low) < wanted:
        low /= 2
        if count(low) > 4 * MOST_PATCHES:
            break
    for _ in range(40):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if count(middle) >= wanted else (low, middle)
    return low


def _parts(face: Face, across: int, along: int) -> list[np.ndarray]:
    """The corners of each patch, counter-clockwise seen from outside."""
    u, v = np.linspace(0, 1, across + 1), np.linspace(0, 1, along + 1)
    found = []
    for outline in face.outlines:
        whole = len(outline) == 4 and np.allclose(np.sort(outline, axis=0), [[0, 0], [0, 0], [1, 1], [1, 1]])
        for i in range(across):
            column = outline if whole else cut(cut(outline, 0, u[i], True), 0, u[i + 1], False)
            for j in range(along):
                if whole:
                    part = np.asarray([[u[i], v[j]], [u[i + 1], v[j]], [u[i + 1], v[j + 1]], [u[i], v[j + 1]]])
                else:
                    part = cut(cut(column, 1, v[j], True), 1, v[j + 1], False)
                if area_of(part) > SLIVER / (across * along):
                    found.append(part)
    sizes = np.cumsum([len(part) for part in found])[:-1]
    return np.split(face.at(np.concatenate(found))[0], sizes)


def _areas(chart: Chart, flat: np.ndarray) -> np.ndarray:
    """Those of the patches of a chart, of a round one by a finer grid."""
    if chart.face.frame is None:
        return flat
    across, along = (max(1, cells) for cells in chart.cells)
    u, v = np.linspace(0, 1, FINER * across + 1), np.linspace(0, 1, FINER * along + 1)
    uv = np.stack([axis.ravel() for axis in np.meshgrid(u, v, indexing="ij")], axis=-1)
    grid = chart.face.at(uv)[0].reshape(len(u), len(v), 3)
    one, other = grid[1:, 1:] - grid[:-1, :-1], grid[:-1, 1:] - grid[1:, :-1]
    parts = 0.5 * np.linalg.norm(np.cross(one, other), axis=-1)
    return parts.reshape(across, FINER, along, FINER).sum(axis=(1, 3)).ravel()


def _site_places(face: Face, across: int, along: int) -> Float[np.ndarray, "n 2"]:
    """The corners of the grid, those outside of the face moved to the nearest place in it; one: its middle."""
    middles = np.stack([outline.mean(axis=0) for outline in face.outlines])
    if not across:
        return middles[:1]
    u, v = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, along + 1), indexing="ij")
    uv = np.stack([u.ravel(), v.ravel()], axis=-1)
    size, best, found = np.asarray(face.lengths()), np.full(len(uv), np.inf), uv.copy()
    for outline, middle in zip(face.outlines, middles, strict=True):
        inner = middle + (outline - middle) * (1 - INSET)
        place = _nearest_within(uv, inner, size)
        away = np.linalg.norm((place - uv) * size, axis=1)
        found, best = np.where((away < best)[:, None], place, found), np.minimum(away, best)
    return found


def _nearest_within(points, loop, size):
    """The nearest point of a convex polygon, counter-clockwise, to each point."""
    start, way = loop, np.roll(loop, -1, axis=0) - loop
    from_start = points[:, None] - start
    inside = (way[:, 0] * from_start[..., 1] - way[:, 1] * from_start[..., 0] >= 0).all(axis=1)
    share = np.clip(((from_start * way) * size**2).sum(axis=-1) / ((way * size) ** 2).sum(axis=-1), 0, 1)
    place = start + way * share[..., None]
    nearest = np.linalg.norm((points[:, None] - place) * size, axis=-1).argmin(axis=1)
    return np.where(inside[:, None], points, place[np.arange(len(points)), nearest])


def _sides(objects, faces: list[list[Face]], others: np.ndarray):
    """Each face with those of its sides that see something."""
    corners = [np.concatenate([face.at(outline)[0] for face in mine for outline in face.outlines]) for mine in faces]
    size = max(float(np.ptp(np.concatenate([*corners, others]), axis=0).max()), 1e-30)
    for number, (thing, mine) in enumerate(zip(objects, faces, strict=True)):
        apart = [points for k, points in enumerate(corners) if k != number]
        seen = np.concatenate([*apart, others, *([] if thing.solid else [corners[number]])])
        if thing.solid:
            within, outside = _about(thing, [others, *apart])
            yield from ((face, inner) for inner, there in ((False, outside), (True, within)) if there for face in mine)
            continue
        for face in mine:
            height = (seen - face.at(face.outlines[0])[0][0]) @ face.normal
            there = bool((height > LEVEL * size).any()), bool((height < -LEVEL * size).any())
            if not any(there):
                there = True, False
            yield from ((face, inner) for inner, yes in zip((False, True), there, strict=True) if yes)


def _about(thing: AbstractObject, groups: list[np.ndarray]) -> tuple[bool, bool]:
    """Does some place lie within a body, and some outside of it? With nothing there, it is looked at from outside."""
    middle = thing.ball()[0]
    places = [place for group in groups for place in (group if group is groups[0] else _few(group))]
    # What lies on its surface lies outside.
    held = [thing.holds(middle + (place - middle) * (1 + ON_IT)) for place in places]
    return any(held), not all(held) or not held


def _few(points: np.ndarray) -> np.ndarray:
    """A few of many points, and their middle: bodies do not run through each other's surfaces."""
    chosen = points[np.linspace(0, len(points) - 1, min(len(points), 4)).astype(int)]
    return np.concatenate([chosen, points.mean(axis=0)[None]])
