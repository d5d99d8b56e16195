"""Lights and polygons of any size: no product of lengths leaves the range of float32."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.numerics._vector import Vec3


@pytest.mark.parametrize("distance", [1e-30, 0.5, 2.0, 1e15, 1e20, 1e30])
@pytest.mark.parametrize("attenuation", [None, (1, 1, 0), (1, 0, 0), (0, 0, 1), (0, 1e-20, 0)])
def test_what_arrives_from_a_light_at_any_distance(distance, attenuation):
    """Direction, distance and min(1, 1 / (a0 + a1 d + a2 d**2)), worked out in Python's numbers; all derivatives are
    finite.
    """
    light = dw.PointLight(np.float32([0.6 * distance, 0, -0.8 * distance]), (1, 1, 1), attenuation)
    light = jax.tree.map(lambda a: a.astype(jnp.float32), light)
    zero = jnp.zeros(1, jnp.float32)

    def arriving(light, x):
        return light.arriving(Vec3(x, zero, zero))

    direction, far, colour = arriving(light, zero)
    np.testing.assert_allclose([direction.x[0], direction.y[0], direction.z[0]], [0.6, 0, -0.8], rtol=1e-6)
    np.testing.assert_allclose(far, distance, rtol=1e-6)
    a0, a1, a2 = attenuation or (1, 0, 0)
    expected = min(1.0, 1 / (a0 + a1 * distance + a2 * distance**2))
    np.testing.assert_allclose(np.broadcast_to(colour.x, 1), expected, rtol=1e-5, atol=1e-37)
    weighed = eqx.filter_grad(lambda light, x: sum(jnp.sum(a) for a in jax.tree.leaves(arriving(light, x)[::2])))
    # Nearer than 1e-19 m the direction turns by more than float32 holds; little faded at 1e20 m, a2 does, by d**2.
    if distance > 1e-10 and (distance < 1e18 or not attenuation or expected < 1e-15):
        for derivative in (weighed(light, zero), jax.jacfwd(lambda x: arriving(light, x))(zero)):
            assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(derivative))


@pytest.mark.parametrize("attenuation", [None, (1, 0, 0), (1, 1, 0), (1, 1, 1)])
def test_a_far_light_lights_like_one_at_infinity(attenuation):
    """Without a fade a lamp at 1e20 m is a directional light; with one nothing of it is left."""

    def picture(light):
        scene = dw.Scene(
            objects=[dw.Sphere("ball", (0, 0, 0), 1, "m"), dw.Plane("floor", (0, 1, 0), -1, "m")],
            materials={"m": dw.Material(k_a=0.1, k_d=0.5, k_h=0.3, k_s=0.2)},
            lights=[light] if light else [],
            background=dw.GradientBackground((0.1, 0.2, 0.9), (0.9, 0.9, 0.9)),
        )
        return np.asarray(dw.render(scene, dw.Camera((0, 1, 5), (0, 0, 0), 40, 16, 12)))

    lit = dw.DirectionalLight((1, 2, 2), (1, 1, 1)) if not attenuation or attenuation == (1, 0, 0) else None
    far = picture(dw.PointLight((1e20, 2e20, 2e20), (1, 1, 1), attenuation))
    np.testing.assert_allclose(far, picture(lit), atol=2e-6)


@pytest.mark.parametrize("size", [1e-15, 1e-12, 1.0, 1e9, 1e15])
def test_a_polygon_of_any_size_is_there(size):
    """A matte square that fills the view: k_a of ambient light."""
    corners = size * np.array([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)])
    scene = dw.Scene(objects=[dw.Polygon("sheet", corners, "m")], materials={"m": dw.Material(k_a=0.25)})
    image = dw.render(scene, dw.Camera((0, 0, 3 * size), (0, 0, 0), 40, 4, 3))
    np.testing.assert_allclose(image, 0.25, rtol=1e-6)
