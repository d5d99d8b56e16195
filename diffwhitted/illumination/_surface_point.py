"""What a point is made of: the one record that the laws of light are asked about."""

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int

from ..geometry import Footprint
from ..numerics._vector import Vec3, dot
from ..optics import refraction_radicand, sine_squared
from ..scene.backgrounds import Surroundings


class Bent(eqx.Module):
    """What is beneath normals that are bent."""

    unbent: Vec3
    """The normal that light would see, on the side of the ray."""
    horizon: Float[Array, "n"]
    """The sine of the angle by which it is bent; 0 where it is not."""
    width: Float[Array, "n"]
    """Of the cone of the pixel, metres, across the ray."""


class SurfacePoint(eqx.Module):
    """A point where a ray met a surface. Every field is finite, also where nothing was met."""

    there: Bool[Array, "n"]
    """Something was met."""
    position: Vec3
    normal: Vec3
    """Geometric unit normal on the side of the ray."""
    shading_normal: Vec3
    """The normal that light sees."""
    incoming: Vec3
    """Unit direction of travel of the ray that arrived."""
    distance: Float[Array, "n"]
    """That it travelled, metres."""
    entering: Bool[Array, "n"]
    """It came from the outer side."""
    material: Int[Array, "n"]
    models: dict[str, Int[Array, "n"]]
    """What its material has chosen, by the name of the choice (see `CHOICES`)."""
    coefficients: dict[str, Vec3 | Float[Array, "n"]]
    """By name, with their textures applied."""
    index_here: Float[Array, "n"] | None
    """Refractive index on the side of the ray; None where nothing is refracted."""
    index_beyond: Float[Array, "n"] | None
    """On the other side."""
    footprint: Footprint | None
    """How point and direction change over the pixel; None for points."""
    curvature: Float[Array, "n"] | None
    """The normal changes by this times a small step along the surface; None for points."""
    uv: tuple[Float[Array, "n"], Float[Array, "n"]] | None = None
    """Texture coordinates that the object brings along; None where no shape of the scene has any."""
    bent: Bent | None = None
    """What is beneath bent normals; None where none are."""
    left: Float[Array, "n"] | None = None
    """What effects leave of light on its way from here to where the ray came from; None: all of it."""
    surroundings: Surroundings | None = None
    """What lights all points from far around; None where nothing does or it is not asked for."""
    gathered: Vec3 | None = None
    """H / pi, of the light that arrives from diffuse surfaces; None where it is not asked for."""
    mean_radicand: Float[Array, "n"] | None = None
    """Of cos_r**2 over the part of a pixel that lies before the rim of total reflection; None: that of the point."""

    def colour(self, name: str) -> Vec3:
        """A coefficient that is linear RGB."""
        found = self.coefficients[name]
        assert isinstance(found, Vec3)
        return found

    @property
    def cosine(self) -> Float[Array, "n"]:
        """cos of the angle of incidence."""
        return -dot(self.incoming, self.shading_normal)

    @property
    def eta(self) -> Float[Array, "n"]:
        """Index on the ray's side over the index on the far side."""
        return self.index_here / self.index_beyond

    @property
    def radicand(self) -> Float[Array, "n"]:
        """cos_r**2, negative at total internal reflection."""
        if self.mean_radicand is not None:
            return self.mean_radicand
        eta = self.eta
        return refraction_radicand(self.cosine, eta, sine_squared(self.incoming, self.shading_normal, eta))
