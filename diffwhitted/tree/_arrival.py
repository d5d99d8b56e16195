"""What is known of a ray in the tree: where it came from, and how it arrived at its surface."""

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int

from ..geometry import Departure, Edge, Footprint, Hit
from ..illumination import Bent
from ..numerics._vector import Vec3

CAMERA, MIRROR, TRANSMITTED, TOTAL, PAST = range(5)
"""The branches of the tree: a camera ray, the mirror ray weighted by k_s, the transmitted ray weighted by k_t,
the mirror ray of total internal reflection, which carries everything, and the part of a ray that runs past the
silhouette of an object."""

BRANCH_NAMES = ("camera", "mirror", "transmitted", "total", "past")
BRANCHES = 8
"""A child is known by BRANCHES * parent + branch."""


class Origin(eqx.Module):
    """Where rays come from in the tree."""

    sample: Int[Array, "n"]
    """Which sample of the pass the ray belongs to."""
    level: Int[Array, "n"]
    """1 for a camera ray."""
    lineage: Int[Array, "n"]
    """BRANCHES * parent + branch, the parent by the number of its node."""

    @property
    def branch(self) -> Int[Array, "n"]:
        return self.lineage % BRANCHES

    @property
    def parent(self) -> Int[Array, "n"]:
        return self.lineage // BRANCHES


class Beam(eqx.Module):
    """What is known of a ray with a footprint where it meets its surface: all for the part of the pixel that the
    object covers.
    """

    footprint: Footprint
    """The change of the point along the surface, and of the direction."""
    curvature: Float[Array, "n"]
    """The normal, on the side of the ray, changes by this times a step along the surface."""
    edge: Edge
    outline: Int[Array, "n"] | None
    """The silhouette that cuts the pixel where one does: the surface, or a side of a mesh; None where there is no mesh:
    the surface.
    """
    departure: Departure | None
    """Where the ray set out; None in the replay, which does not search."""
    uv_steps: tuple[tuple[Float[Array, "n"], Float[Array, "n"]], ...] | None = None
    """The change of the texture coordinates along each side of the pixel; None: not known."""


class Arrival(eqx.Module):
    """How a ray arrived at its surface: all that its children start from."""

    point: Vec3
    normal: Vec3
    """Geometric, on the side of the ray."""
    shading_normal: Vec3
    direction: Vec3
    distance: Float[Array, "n"]
    """Travelled by the ray that arrived, metres."""
    primitive: Int[Array, "n"]
    object: Int[Array, "n"]
    entering: Bool[Array, "n"]
    outside: Int[Array, "n"] | None
    """The solid around the object, -1 for none; None where the plan knows no nested media."""
    inside: Int[Array, "n"] | None
    """The object whose index counts on the inner side; None: the object itself."""
    beam: Beam | None
    """None where rays have no footprint."""
    lifted: Vec3 | None = None
    """Where shadow rays leave; None where no surface interpolates normals: from the point."""
    start: Vec3 | None = None
    """Where other rays leave; None where no surface is detached: from the point."""
    uv: tuple[Float[Array, "n"], Float[Array, "n"]] | None = None
    """Texture coordinates that the object brings along; None where no shape of the scene has any."""
    bent: Bent | None = None
    """What is beneath the normals that wrinkles bend; None where none are bent."""

    @property
    def lit_from(self) -> tuple[Vec3, Departure]:
        """Where shadow rays leave, and on which side: the shading normal faces the eye, so a lit point sees its light
        on the side that the ray came from.
        """
        return self.point if self.lifted is None else self.lifted, Departure(self.primitive, ~self.entering)


def arrival(hit: Hit, direction: Vec3, outside, inside, beam: Beam | None) -> Arrival:
    return Arrival(
        hit.point,
        hit.normal,
        hit.shading_normal,
        direction,
        hit.distance,
        hit.primitive,
        hit.object,
        hit.entering,
        outside,
        inside,
        beam,
        hit.lifted,
        hit.start,
        hit.uv,
    )
