"""Form factors of a scene as the ray tree reads them: made once for each geometry, and kept by its content."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from .._errors import SceneError
from ..geometry import Shapes
from ..interreflection import Factors, form_factors, patches_of
from ..numerics._recent import Recent
from ..numerics._vector import Vec3, vec3
from ..records import is_traced
from ..shapes import AbstractObject
from ._interreflection import numbered, obstacles_of, opaque


class Charts(eqx.Module):
    """Where the sites are, at which light is gathered, by the place of a point on its surface."""

    first: Int[Array, "2 surfaces"]
    """The first chart of each surface, seen from its outer and from its inner side; -1: nobody looks there."""
    by_slot: Int[Array, "surfaces"]
    """How a chart is told among those of a surface: 0, there is one; 1, by the crossing; 2, by the face of a cube."""
    middle: Vec3
    """Of the cube of each surface; 0 of the others."""
    rows: tuple[Vec3, Vec3, Vec3]
    """Of the matrix that makes a cube of side 2 of it."""
    origin: Vec3
    """Of each chart, and the ways by which u and v are read off."""
    along: Vec3
    across: Vec3
    cells: tuple[Float[Array, "charts"], Float[Array, "charts"]]
    site: Int[Array, "charts"]


class PatchTables(eqx.Module):
    """Form factors with what is needed to light the patches."""

    matrix: Float[Array, "n n"]
    area: Float[Array, "n"]
    gather: Float[Array, "s n"]
    object: Int[Array, "n"]
    """By its place in the scene."""
    points: Vec3
    """(n, samples)."""
    normals: Vec3
    surface: Int[Array, "n"]
    """Among the obstacles; -1 for none of them."""
    inwards: Bool[Array, "n"]
    obstacles: Shapes | None
    """What may hide a lamp from a patch; None: nothing."""
    charts: Charts


_KEPT: Recent[tuple[Factors, PatchTables]] = Recent(4)
"""Of scenes that come again."""


def known_patches(
    objects: Sequence[AbstractObject], others: np.ndarray, patches: int, dtype
) -> tuple[Factors, PatchTables]:
    """The form factors of objects where they are. `others`: places (m, 3) from which faces are looked at too.

    Raises `SceneError` for traced geometry, and as `patches_of` does.
    """
    for thing in objects:
        if any(map(is_traced, jax.tree.leaves(thing))):
            raise SceneError(
                f"object {thing.name!r}: its place or shape is traced (by jit, grad or vmap, or free in a fit), and "
                "form factors are made of known geometry, once; allowed are derivatives in materials, lights and "
                "cameras. Close over the scene and replace coefficients, or leave radiosity out"
            )
    # All that the form factors hang on: what is asked for, precision, and each object.
    content = [f"{patches} {dtype} {jnp.asarray(0.0).dtype}", others]
    for thing in objects:
        content += [f"{type(thing).__name__} {thing.surfaces} {thing.solid}", *jax.tree.leaves(thing)]

    def made() -> tuple[Factors, PatchTables]:
        with jax.ensure_compile_time_eval():
            return _made(objects, others, patches, dtype)

    return _KEPT.of(content, made)


def _made(objects, others, wanted: int, dtype) -> tuple[Factors, PatchTables]:
    patches = patches_of(objects, wanted, others)
    obstacles = obstacles_of(objects, patches)
    factors = form_factors(patches, obstacles.sees(patches), opaque(objects).escapes(patches))
    number, inwards = obstacles.departures(patches)
    matrix, area, gather = (jnp.asarray(a, dtype) for a in (factors.matrix, patches.area, factors.gather))
    points, normals = (vec3(jnp.asarray(a, dtype)) for a in (patches.samples.position, patches.samples.normal))
    return factors, PatchTables(
        matrix, area, gather, jnp.asarray(patches.object, jnp.int32), points, normals,
        jnp.asarray(number[patches.chart]), jnp.asarray(inwards[patches.chart]), obstacles.shapes,
        _charts(objects, factors, dtype),
    )  # fmt: skip


def _charts(objects: Sequence[AbstractObject], factors: Factors, dtype) -> Charts:
    """Where the charts of each surface are, by the numbering of the ray tree."""
    charts = factors.patches.charts
    counts = {k: objects[k].surfaces for k in numbered(objects)}
    start = dict(zip(counts, np.cumsum([0, *counts.values()]).tolist(), strict=False))
    total = sum(counts.values())
    first, kind = np.full((2, total), -1), np.zeros(total, int)
    middle, rows = np.zeros((total, 3)), np.tile(np.eye(3), (total, 1, 1))
    for number, chart in enumerate(charts):
        surface = start[chart.face.object] + chart.face.surface
        if chart.face.slot == 0:
            first[int(chart.inner), surface] = number
        if chart.face.frame is not None:
            kind[surface], middle[surface] = 2, chart.face.frame.middle
            rows[surface] = np.linalg.inv(chart.face.frame.ways)
        elif chart.face.slot:
            kind[surface] = 1
    ways = []
    for chart in charts:
        along, across = chart.face.along, chart.face.across
        ways.append((chart.face.origin, along / (along @ along), across / (across @ across)))
    origin, along, across = (vec3(jnp.asarray(np.stack(part), dtype)) for part in zip(*ways, strict=True))
    cells = np.asarray([chart.cells for chart in charts])
    whole = jnp.asarray(first, jnp.int32), jnp.asarray(kind, jnp.int32), vec3(jnp.asarray(middle, dtype))
    x, y, z = (vec3(jnp.asarray(rows[:, k], dtype)) for k in range(3))
    columns = jnp.asarray(cells[:, 0], dtype), jnp.asarray(cells[:, 1], dtype)
    site = jnp.asarray([chart.first for chart in charts], jnp.int32)
    return Charts(*whole, (x, y, z), origin, along, across, columns, site)
