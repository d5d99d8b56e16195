"""What a surface sends back of a background that lights it: diffusely, and in the highlight that it states."""

import jax
import jax.numpy as jnp
import numpy as np

from ..illumination import AROUND, SurfacePoint, polished_most
from ..numerics._vector import Vec3, dot, lookup
from ..optics import mirrored
from ..scene import Scene


def sent_back_diffusely(point: SurfacePoint) -> Vec3:
    """k_d E / pi, E the irradiance of what lies around: an even background of 1 gives k_d.

    Of a polished surface it has the weight of ambient light in place of k_d, which is exact under an even background.
    """
    assert point.surroundings is not None, "without a background that lights, the effect is off"
    k_d = point.colour(AROUND if AROUND in point.coefficients else "k_d")
    return k_d * point.surroundings.mean(point.shading_normal)


def sent_back_in_highlight(point: SurfacePoint) -> Vec3:
    """k_h (n + 1) / (2 pi) times the integral of L(w) max(R.w, 0)^n, R the mirrored direction: of 1 it gives k_h.

    Where rays have a footprint the lobe is as much wider as R turns over the pixel (see `lobe_mean`). 0 for materials
    that state no k_h.
    """
    assert point.surroundings is not None, "without a background that lights, the effect is off"
    exponent = point.coefficients["phong_exponent"]
    if point.footprint is not None:

        def turned(step) -> Vec3:
            change = step.direction, step.origin * point.curvature
            return jax.jvp(mirrored, (point.incoming, point.shading_normal), change)[1]

        variance = sum(dot(turn, turn) for turn in map(turned, point.footprint.sides())) / 24
        exponent = exponent / (1 + exponent * variance)
    light = point.surroundings.lobe(mirrored(point.incoming, point.shading_normal), exponent)
    shiny = lookup(point.surroundings.shiny, point.material) & point.there
    light = Vec3(*(jnp.where(shiny, channel, 0) for channel in (light.x, light.y, light.z)))
    return point.colour("k_h") * light


def brightest_of(coefficient: str):
    """The most that a material sends back of what is around by one of its coefficients, (3,)."""

    def brightest(scene: Scene, name: str) -> np.ndarray:
        material = scene.materials[name]
        if coefficient == "k_h" and not material.is_shiny:
            return np.zeros(3)
        value, worn = np.asarray(material.at_work(coefficient), np.float64), material.texture_at_work(coefficient)
        share = np.broadcast_to(value * (1.0 if worn is None else scene.textures[worn].brightest()), 3)
        if coefficient == "k_d" and material.class_ == "polished":
            share = polished_most({"k_a": share, "k_d": share}, float(material.refractive_index))["k_a"]
        return np.where(share > 0, share * scene.background.brightest_mean(), 0.0)

    return brightest
