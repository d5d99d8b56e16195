"""The picture under `jit`: right whatever the room for its rays, forwards and backwards, in memory that follows the
rays.
"""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.numerics._transposed import linear
from diffwhitted.scene import tabulate
from diffwhitted.tree import make_plan
from diffwhitted.tree._record import follow
from diffwhitted.tree._retrace import light_of
from diffwhitted.tree._samples import Window, grid

WIDTH, HEIGHT = 20, 15


def mirrors_and_glass(max_depth: int = 6, **settings) -> dw.Scene:
    """A glass ball between two mirrors: some twenty rays behind each camera ray."""
    return dw.Scene(
        objects=[
            dw.Sphere("ball", (0, 0, 0), 0.7, "glass"),
            dw.Plane("floor", (0, 1, 0), -1, "mirror"),
            dw.Plane("ceiling", (0, -1, 0), -1, "mirror"),
        ],
        materials={
            "glass": dw.Material(k_a=0.1, k_d=0.2, k_s=0.3, k_t=0.6, k_h=0.2, phong_exponent=8, refractive_index=1.4),
            "mirror": dw.Material(k_a=0.1, k_d=0.3, k_s=0.5, k_h=0.0),
        },
        lights=[dw.PointLight((1.5, 0.8, 2), 0.8)],
        ambient=0.5,
        background=dw.GradientBackground((0.7, 0.6, 0.5), (0.2, 0.3, 0.6)),
        cameras={"main": dw.Camera((0.2, 0.1, 3), (0, 0, 0), 50, WIDTH, HEIGHT)},
        max_depth=max_depth,
        precision="float64",
        **settings,
    )


def changed(scene: dw.Scene, values) -> dw.Scene:
    for name, value in zip(("glass.k_t", "glass.refractive_index", "mirror.k_s"), values, strict=True):
        scene = dw.replace_coefficient(scene, name, value)
    return scene


VALUES = jnp.asarray([0.6, 1.4, 0.5])


def pictures(scene: dw.Scene, plan, *, weights):
    """Picture, loss and its reverse derivative, picture along a direction: by a program with this plan."""

    def picture(values):
        return dw.render(changed(scene, values), scene.cameras["main"], plan=plan)

    @partial(jax.jit, compiler_options=SOON_COMPILED)
    def program(values):
        loss = jax.grad(lambda v: (weights * picture(v)).sum())
        return picture(values), loss(values), jax.jvp(picture, (values,), (jnp.asarray([1.0, -0.5, 0.25]),))

    return program(VALUES)


def test_room_for_one_ray_in_a_hundred_gives_the_same():
    """Windows of the pass are halved until their trees fit; forwards and backwards as in one piece."""
    scene = mirrors_and_glass()
    camera = scene.cameras["main"]
    weights = np.random.default_rng(1).normal(size=(HEIGHT, WIDTH, 3))
    ample, small = dw.plan(scene, camera), make_plan(scene, camera, capacity=1, block_of=64)
    assert small.capacity < 0.1 * ample.capacity
    expected, tight = (pictures(scene, plan, weights=weights) for plan in (ample, small))
    for e, t in zip(jax.tree.leaves(expected), jax.tree.leaves(tight), strict=True):
        np.testing.assert_allclose(t, e, atol=1e-11 * np.abs(e).max())
    picture, reverse, (_, along) = expected
    np.testing.assert_allclose(picture, dw.render(scene, camera), atol=1e-12)
    np.testing.assert_allclose(reverse @ np.array([1.0, -0.5, 0.25]), (weights * along).sum(), rtol=1e-9)


def test_a_tree_of_one_ray_that_outgrows_the_room_makes_all_nan():
    scene = mirrors_and_glass(max_depth=9)
    camera = scene.cameras["main"]
    small = make_plan(scene, camera, capacity=1, block_of=64)

    def brightness(values):
        return dw.render(changed(scene, values), camera, plan=small)[0, 0, 0]

    value, slope = jax.jit(jax.value_and_grad(brightness), compiler_options=SOON_COMPILED)(VALUES)
    assert np.isnan(value) and np.isnan(slope).all()


def test_deep_trees_of_a_small_picture_have_room_without_a_plan():
    """Both branches at every level: a tree of hundreds of rays behind one pixel."""
    scene = mirrors_and_glass(max_depth=10)
    camera = scene.cameras["main"].resized(1, 1)
    traced = jax.jit(lambda v: dw.render(changed(scene, v), camera), compiler_options=SOON_COMPILED)(VALUES)
    np.testing.assert_allclose(traced, dw.render(scene, camera), atol=1e-12)
    assert np.isfinite(traced).all()


@pytest.mark.parametrize("derive", [lambda fn: fn, jax.grad], ids=["picture", "gradient"])
def test_memory_without_a_plan(derive):
    """At most three times that with a plan; clearing the worst case took 13 and 8 times (154 MiB at 160x120)."""
    scene = mirrors_and_glass(max_depth=6)
    camera = scene.cameras["main"].resized(160, 120)

    def memory(plan):
        def brightness(value):
            return dw.render(dw.replace_coefficient(scene, "glass.k_d", value), camera, plan=plan).mean()

        compiled = jax.jit(derive(brightness), compiler_options=SOON_COMPILED).lower(0.2).compile()
        return compiled.memory_analysis().temp_size_in_bytes

    assert memory(None) < 3 * memory(dw.plan(scene, camera))


def test_rays_that_carry_no_light_are_not_followed_under_jit():
    """A plan has mirror rays for a k_s that may be anything; where it is zero none is traced, and the derivative is
    there.
    """
    scene = mirrors_and_glass()
    camera = scene.cameras["main"]
    plan = make_plan(scene, camera)
    dark = dw.replace_coefficient(dw.replace_coefficient(scene, "mirror.k_s", 0.0), "glass.k_s", 0.0)

    def rays(scene, k_t):
        tables = tabulate(dw.replace_coefficient(scene, "glass.k_t", k_t))
        samples = grid(plan, camera, jnp.int32(0), jnp.asarray([0.5, 0.5]))
        window = Window(jnp.int32(0), jnp.int32(plan.pass_pixels))

        def light(nodes, ray, *at):
            return (light_of(tables, plan, nodes, *at),)

        return int(follow(tables, camera, plan, samples, light, window=window)[0].descendants)

    assert rays(dark, 0.0) == 0 < rays(dark, 0.5) < rays(scene, 0.5)

    def brightness(k_s):
        return dw.render(dw.replace_coefficient(dark, "mirror.k_s", k_s), camera, plan=plan).mean()

    slope = jax.jit(jax.grad(brightness), compiler_options=SOON_COMPILED)(0.0)
    np.testing.assert_allclose(slope, (brightness(1e-5) - brightness(0.0)) / 1e-5, rtol=1e-3)
    assert slope > 0.01


def test_second_derivatives():
    """Forward over reverse. Between two mirrors that glow with k_a: k_a (1 + k_s + k_s^2 + k_s^3), by hand."""
    floor, ceiling = (dw.Plane(name, (0, 1, 0), offset, "mirror") for name, offset in (("floor", -1), ("ceiling", 1)))
    material = dw.Material(k_a=0.1, k_s=0.5, k_h=0.0)
    camera = dw.Camera((0, 0, 0), (0.6, -0.8, 0), 20, 1, 1)
    scene = dw.Scene(
        objects=[floor, ceiling],
        materials={"mirror": material},
        cameras={"main": camera},
        ambient=1.0,
        max_depth=4,
        precision="float64",
    )

    def glow(k_s, k_a):
        there = dw.replace_coefficient(dw.replace_coefficient(scene, "mirror.k_s", k_s), "mirror.k_a", k_a)
        return dw.render(there, camera)[0, 0, 0]

    found = jax.jit(jax.hessian(glow, argnums=(0, 1)), compiler_options=SOON_COMPILED)(0.5, 0.1)
    np.testing.assert_allclose(found, [[0.1 * (2 + 6 * 0.5), 1 + 2 * 0.5 + 3 * 0.25], [2.75, 0.0]], atol=1e-12)


# A linear function with its transpose, in all modes: sin(A sin(A ... x)) in a loop of unknown length.


def sines(a, x, steps):
    return jax.lax.fori_loop(0, steps, lambda _, x: jnp.sin(a @ x), x)


@jax.custom_jvp
def by_hand(a, x, steps):
    return sines(a, x, steps)


@by_hand.defjvp
def _by_hand_jvp(primals, tangents):
    def forward(known, tangents):
        *moving, steps = known
        return jax.jvp(lambda a, x: sines(a, x, steps), tuple(moving), tangents)[1]

    def backward(known, cotangent):
        a, x, steps = known
        kept = jnp.zeros((8, x.size), x.dtype)
        kept = jax.lax.fori_loop(0, steps, lambda n, k: k.at[n].set(sines(a, x, n)), kept)

        def step(n, carry):
            of_a, of_x = carry
            more, of_x = jax.vjp(lambda a, x: jnp.sin(a @ x), a, kept[steps - 1 - n])[1](of_x)
            return of_a + more, of_x

        return jax.lax.fori_loop(0, steps, step, (jnp.zeros_like(a), cotangent))

    return by_hand(*primals), linear(forward, backward, primals, tangents[:2])


def unrolled(a, x, steps):
    for _ in range(steps):
        x = jnp.sin(a @ x)
    return x


MODES = {
    "grad": lambda f: jax.grad(lambda a, x: (f(a, x, 4) ** 2).sum(), argnums=(0, 1)),
    "jacfwd": lambda f: jax.jacfwd(lambda a, x: f(a, x, 4), argnums=(0, 1)),
    "jacrev": lambda f: jax.jit(jax.jacrev(lambda a, x: f(a, x, 4), argnums=(0, 1))),
    "hessian": lambda f: jax.hessian(lambda a, x: (f(a, x, 4) ** 2).sum()),
    "linearize": lambda f: lambda a, x: jax.linearize(lambda x: f(a, x, 4), x)[1](2 * x),
    "vmap of grad": lambda f: (
        lambda a, x: jax.vmap(jax.grad(lambda a, x: (f(a, x, 4) ** 2).sum(), argnums=(0, 1)), in_axes=(0, None))(
            jnp.stack([a, 2 * a]), x
        )
    ),
    "grad of vmap": lambda f: jax.grad(
        lambda a, x: jax.vmap(lambda x: (f(a, x, 4) ** 2).sum(), in_axes=1)(jnp.stack([x, 2 * x], axis=1)).sum()
    ),
}


@pytest.mark.parametrize("mode", MODES)
def test_a_linear_function_with_its_transpose(mode):
    random = np.random.default_rng(0)
    a, x = jnp.asarray(random.normal(size=(3, 3))), jnp.asarray(random.normal(size=3))
    found, expected = (jax.tree.leaves(MODES[mode](f)(a, x)) for f in (by_hand, unrolled))
    for f, e in zip(found, expected, strict=True):
        np.testing.assert_allclose(f, e, atol=1e-12)
