"""Random scenes, awkward ones among them: no NaN and no infinity in the image or in either mode of its derivative.

The structure of the scenes is fixed, so that each kind is compiled once; everything that is a number varies. Whole
numbers are drawn often, for what they bring about: a camera at a centre, on a surface or inside, a light at a point,
spheres that touch, coincide or are cut by planes, and coefficients of exactly 0 and 1.
"""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import diffwhitted as dw
from diffwhitted.tree import make_plan

pytestmark = pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
"""Random scenes are often black, or have lamps inside of things."""


def number(low, high):
    return st.integers(low, high).map(float) | st.floats(low, high, width=32)


def triple(low, high):
    return st.tuples(*[number(low, high)] * 3)


place, direction = triple(-4, 4), triple(-3, 3).filter(lambda v: max(map(abs, v)) > 1e-3)
share, colour = number(0, 1), triple(0, 1)
radius = st.sampled_from([0.01, 1.0, 2.0]) | st.floats(0.125, 3, width=32)
exponent = st.sampled_from([0.0, 1.0, 1e6]) | st.floats(0, 1000, width=32)
index = st.sampled_from([1.0, 1.5, 4.0]) | st.floats(1, 3, width=32)


def material(**settings):
    return st.builds(
        functools.partial(dw.Material, **settings),
        k_a=share,
        k_d=colour,
        k_h=share,
        k_s=colour,
        k_t=share,
        phong_exponent=exponent,
        refractive_index=index,
    )


def sphere(name):
    return st.builds(lambda centre, radius: dw.Sphere(name, centre, radius, name), place, radius)


def plane(name):
    return st.builds(lambda normal, offset: dw.Plane(name, normal, offset, name), direction, number(-4, 4))


@st.composite
def triangle(draw, name):
    """Three points with an area, by two edges that are not parallel."""
    corner, one, other = (np.array(draw(s)) for s in (place, direction, direction))
    if np.linalg.norm(np.cross(one, other)) < 1e-2:
        other = np.roll(one, 1) * np.array([1.0, -1.0, 2.0]) + np.array([0.5, 0.25, -0.125])
    if np.linalg.norm(np.cross(one, other)) < 1e-2:
        other = other + np.array([0.0, 1.0, 3.0])
    return dw.Polygon(name, [corner, corner + one, corner + one + other], name)


@st.composite
def camera(draw):
    position, ahead, up = (np.array(draw(s)) for s in (place, direction, direction))
    if np.linalg.norm(np.cross(ahead, up)) < 1e-2 * np.linalg.norm(ahead) * np.linalg.norm(up):
        up = np.eye(3)[np.abs(ahead).argmin()]
    return dw.Camera(
        position, position + ahead, draw(st.sampled_from([1.0, 90.0]) | st.floats(5, 150, width=32)), 8, 6, up=up
    )


KINDS = {
    "balls": st.builds(
        lambda objects, glass, metal, floor, light, tiles, sky, camera: dw.Scene(
            objects=objects,
            materials={"glass": glass, "metal": metal, "floor": floor},
            lights=[light],
            textures={"tiles": tiles},
            background=sky,
            cameras={"main": camera},
            shadows="tinted",
            max_depth=4,
        ),
        st.tuples(sphere("glass"), sphere("metal"), plane("floor")),
        material(highlight="reflected"),
        material(),
        material(k_d_texture="tiles"),
        st.builds(functools.partial(dw.PointLight, attenuation=(0.0, 1.0, 0.5)), place, colour),
        st.builds(lambda colours, size: dw.Checker(colours, size, "xz"), st.tuples(colour, colour), radius),
        st.builds(dw.GradientBackground, colour, colour),
        camera(),
    ),
    "nested": st.builds(
        lambda objects, water, glass, sheet, light, sky, camera: dw.Scene(
            objects=objects,
            materials={"water": water, "glass": glass, "sheet": sheet},
            lights=[light],
            background=sky,
            cameras={"main": camera},
            total_internal_reflection="whitted",
            max_depth=4,
        ),
        st.tuples(sphere("water"), sphere("glass"), triangle("sheet")),
        material(),
        material(highlight="reflected"),
        material(),
        st.builds(dw.DirectionalLight, direction, colour),
        st.builds(dw.ConstantBackground, colour),
        camera(),
    ),
}


@functools.cache
def derivatives(kind):
    """The image and both derivatives, with everything free, as one program."""
    plans = []

    @eqx.filter_jit(compiler_options=SOON_COMPILED)
    def program(scene, seed):
        keys = iter(jax.random.split(jax.random.key(seed), 64))
        arrays, rest = eqx.partition(scene, eqx.is_array)
        tangents = jax.tree.map(lambda a: jax.random.normal(next(keys), a.shape, a.dtype), arrays)

        def image(arrays):
            changed = eqx.combine(arrays, rest)
            return dw.render(changed, changed.cameras["main"], plan=plans[0])

        value, forward = jax.jvp(image, (arrays,), (tangents,))
        weights = jax.random.normal(next(keys), value.shape, value.dtype)
        return value, forward, jax.vjp(image, arrays)[1](weights)[0]

    def run(scene, seed):
        if not plans:
            free = tuple(f"{material}.{row.name}" for material in scene.materials for row in dw.COEFFICIENTS)
            plans.append(make_plan(scene, scene.cameras["main"], free=free))
        return program(scene, seed)

    return run


@pytest.mark.parametrize("kind", KINDS)
def test_random_scenes_are_finite(kind):
    @settings(max_examples=60, derandomize=True, database=None, deadline=None, suppress_health_check=list(HealthCheck))
    @given(scene=KINDS[kind], seed=st.integers(0, 1000))
    def finite(scene, seed):
        image, forward, reverse = derivatives(kind)(scene, jnp.asarray(seed))
        assert image.shape == (6, 8, 3) and image.dtype == jnp.float32 and (np.asarray(image) >= 0).all()
        assert np.isfinite(image).all() and np.isfinite(forward).all()
        assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(reverse))

    finite()
