"""Edges that the other tests leave out: polygons, glass in glass, things that touch, total internal reflection.

Two scenes of 60x45, one compiled program each. References are central differences of 32 x 32 points a pixel. They are
themselves uncertain by about 0.1 in L2 where a polygon, a light or the camera moves and by 0.2 for an index, which the
limits allow for.
"""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.accuracy._reference import rmse
from diffwhitted.rendering._passes import render_passes
from diffwhitted.tree import make_plan
from references.supersampled import area_true, cosine, relative

SIDE = 32
TILES = {"tiles": dw.Checker([[0.9, 0.1, 0.1], [1, 1, 1]], 1.0, "xz")}
FLOOR = dw.Material(k_d=0.8, k_a=0.2, k_d_texture="tiles", k_a_texture="tiles")
GLASS = {"k_s": 0.1, "k_h": 0.3, "k_t": 0.9, "phong_exponent": 50}


def matt(*colour):
    return dw.Material(k_d=colour, k_a=colour)


def touching():
    """A glass ball with another inside rests on tiles and touches a stone; a triangle stands behind."""
    objects = [
        dw.Sphere("ball", [0, 0, 0], 1, "ball"),
        dw.Sphere("core", [0.1, 0.1, 0.1], 0.45, "core"),
        dw.Sphere("stone", [1.4, -0.4, -0.66332], 0.6, "stone"),
        dw.Plane("ground", [0, 1, 0], -1, "floor"),
        dw.Polygon("sail", [[-2.2, -0.9, -1.2], [-0.2, -0.6, -2.2], [-1.0, 0.9, -1.8]], "sail"),
    ]
    materials = {
        "ball": dw.Material(**GLASS, refractive_index=1.5),
        "core": dw.Material(**GLASS, refractive_index=1.8),
        "stone": matt(0.1, 0.2, 0.6),
        "sail": matt(0.1, 0.6, 0.2),
        "floor": FLOOR,
    }
    return dw.Scene(
        objects=objects,
        materials=materials,
        textures=TILES,
        background=dw.ConstantBackground([0.4, 0.6, 0.9]),
        lights=[dw.PointLight([3, 5, 4], [1.0] * 3)],
        cameras={"main": dw.Camera([0, 0.8, 5], [0.1, 0, 0], 36, 60, 45)},
    )


def pool():
    """From under water: the rim of total reflection, what is above seen through the surface, the bed mirrored in it."""
    objects = [
        dw.Plane("water", [0, 1, 0], 0, "water"),
        dw.Plane("bed", [0, 1, 0], -2, "floor"),
        dw.Sphere("sun", [0.5, 1.2, -1.0], 0.7, "sun"),
    ]
    materials = {
        "water": dw.Material(k_s=0.1, k_h=0.0, k_t=0.9, refractive_index=1.33),
        "floor": FLOOR,
        "sun": matt(0.1, 0.2, 0.6),
    }
    return dw.Scene(
        objects=objects,
        materials=materials,
        textures=TILES,
        background=dw.GradientBackground((0.1, 0.2, 0.6), (0.9, 0.7, 0.2)),
        lights=[dw.PointLight([3, 5, 4], [0.6] * 3)],
        shadows="tinted",
        cameras={"main": dw.Camera([0, -1, 1.5], [0, 0, 0.2], 80, 60, 45)},
    )


def named(scene, name):
    return next(thing for thing in scene.objects if thing.name == name)


TIP, ACROSS, UP = np.array([[0, 0, 0], [0, 0, 0], [0, 1.0, 0]]), np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
"""The tip of the sail upwards, a step to the right, a step up."""
MOVES = {
    "touching": {
        "index": (lambda s: s.materials["ball"].refractive_index, 1.0),
        "tip": (lambda s: named(s, "sail").vertices, TIP),
        "light": (lambda s: s.lights[0].position, ACROSS),
    },
    "pool": {
        "index": (lambda s: s.materials["water"].refractive_index, 1.0),
        "camera": (lambda s: s.cameras["main"].look_from, ACROSS),
        "sun": (lambda s: named(s, "sun").centre, UP),
    },
}
SCENES = {"touching": touching, "pool": pool}
scene_of = functools.cache(lambda name: SCENES[name]())


@functools.cache
def plan_of(name):
    return make_plan(scene_of(name), scene_of(name).cameras["main"], footprint=1, capacity=8 * 60 * 45)


def moved(name, scene, far):
    """The scene with each of its moves made so `far`."""
    for (place, way), distance in zip(MOVES[name].values(), far, strict=True):
        scene = eqx.tree_at(place, scene, (place(scene) + jnp.asarray(way) * distance).astype(scene.dtype))
    return scene


def _image(name, scene, far):
    scene = moved(name, scene, far)
    return render_passes(scene, scene.cameras["main"], plan_of(name))


@eqx.filter_jit
def _forward(name, scene, along):
    return jax.jvp(lambda far: _image(name, scene, far), (jnp.zeros_like(along),), (along,))


def filtered(name, scene, what):
    """Image and derivative of one filtered tree a pixel."""
    (image, needed), (derivative, _) = _forward(name, scene, _unit(name, what))
    assert needed <= plan_of(name).capacity
    return np.asarray(image, np.float64), np.asarray(derivative, np.float64)


def _unit(name, what):
    return jnp.asarray([float(what == one) for one in MOVES[name]], jnp.float32)


def true(name, what, step):
    """Image and derivative by central difference of many points."""
    scenes = [moved(name, scene_of(name), _unit(name, what) * d) for d in (-step, step)]
    below, above = (area_true(scene, scene.cameras["main"], SIDE) for scene in scenes)
    return (below + above) / 2, (above - below) / (2 * step)


@pytest.mark.parametrize(
    "name, what, step, like, off",
    [
        ("touching", "index", 2e-3, 0.94, 0.37),
        ("touching", "tip", 5e-3, 0.975, 0.23),
        ("touching", "light", 2e-2, 0.96, 0.27),
        ("pool", "index", 2e-3, 0.975, 0.22),
        ("pool", "camera", 5e-3, 0.97, 0.24),
        ("pool", "sun", 5e-3, 0.985, 0.16),
    ],
)
def test_the_derivative_is_that_of_the_area(name, what, step, like, off):
    image, slope = true(name, what, step)
    ours, derivative = filtered(name, scene_of(name), what)
    assert cosine(derivative, slope) > like and relative(derivative, slope) < off
    assert rmse(ours, image) < {"touching": 0.0095, "pool": 0.0045}[name]


def lantern():
    """A stone behind glass, both without lamps: outlines, and no more."""
    objects = [dw.Sphere("ball", [0, 0, 0], 1, "ball"), dw.Sphere("stone", [-0.4, -0.2, -1.7], 0.6, "stone")]
    materials = {"ball": dw.Material(k_t=0.9, refractive_index=1.5), "stone": dw.Material(k_a=(0.1, 0.6, 0.2))}
    return dw.Scene(
        objects=objects,
        materials=materials,
        background=dw.GradientBackground((0.1, 0.2, 0.6), (0.9, 0.7, 0.2)),
        cameras={"main": dw.Camera([0, 0.8, 5], [0.1, 0, 0], 36, 24, 18)},
    )


def test_reverse_mode_sees_edges_move():
    """One loss, its gradient in all numbers of the scene along a random direction against both ends of a step.

    What is zero stays zero: the plan was made for a stone that is opaque.
    """
    scene = lantern()
    arrays, rest = eqx.partition(scene, eqx.is_array)
    plan = make_plan(scene, scene.cameras["main"], footprint=1, capacity=6 * 24 * 18)
    random = np.random.default_rng(0)
    along = jax.tree.map(lambda a: jnp.where(a == 0, 0, jnp.asarray(random.normal(size=a.shape), a.dtype)), arrays)

    def loss(arrays):
        image, needed = render_passes(eqx.combine(arrays, rest), eqx.combine(arrays, rest).cameras["main"], plan)
        return ((image - 0.5) ** 2).sum(), needed

    backward = jax.jit(jax.value_and_grad(loss, has_aux=True), compiler_options=SOON_COMPILED)
    (_, needed), gradient = backward(arrays)
    assert needed <= plan.capacity
    reverse = sum(
        (np.asarray(g, np.float64) * np.asarray(v)).sum()
        for g, v in zip(jax.tree.leaves(gradient), jax.tree.leaves(along), strict=True)
    )
    step = 1e-3
    ends = [float(backward(jax.tree.map(lambda a, v, d=d: a + d * v, arrays, along))[0][0]) for d in (-step, step)]
    assert (
        all(np.isfinite(g).all() for g in jax.tree.leaves(gradient))
        and gradient.materials["ball"].refractive_index != 0
    )
    assert reverse == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=0.05)


def awkward(name, seed):
    """The scene with other numbers; some of them bring about what is rare."""
    random = np.random.default_rng(seed)
    scene = scene_of(name)

    def put(place, values):
        nonlocal scene
        scene = eqx.tree_at(place, scene, jnp.asarray(values, scene.dtype))

    camera = {"touching": [0, 0.5, 4], "pool": [0, -1, 1.5]}[name]
    put(lambda s: s.cameras["main"].look_from, camera + random.uniform(-0.8, 0.8, 3))
    put(lambda s: s.cameras["main"].vfov_deg, random.choice([5, 40, 120]))
    put(lambda s: s.lights[0].position, random.uniform(-4, 4, 3))
    for material in [m for m, glass in scene.materials.items() if float(glass.k_t.max()) > 0]:
        put(lambda s: s.materials[material].refractive_index, random.choice([1.0, 1.0001, 1.5, 4.0]))  # noqa: B023
    if name == "touching":
        put(lambda s: named(s, "ball").centre, [0, random.choice([-1.0, -0.5, 0, 1e-3, 3.0]), random.uniform(-1, 4)])
        put(lambda s: named(s, "core").centre, named(scene, "ball").centre + random.choice([0, 0.3, 0.55]) * ACROSS)
        put(lambda s: named(s, "stone").radius, random.choice([1e-3, 0.6, 3.0]))
        thin = random.choice([1e-4, 0.5])
        corner, edge = random.uniform(-2, 2, 3), random.uniform(-1, 1, 3)
        put(
            lambda s: named(s, "sail").vertices,
            [corner, corner + edge, corner + edge * 0.5 + thin * random.uniform(-1, 1, 3)],
        )
    else:
        put(lambda s: s.cameras["main"].look_from, [0, random.choice([-1.999, -0.5, 0.0, 1e-4, 1.0]), 1.5])
        put(lambda s: named(s, "sun").centre, random.uniform(-2, 2, 3))
    return scene


@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize("name", SCENES)
def test_awkward_scenes_are_finite_and_as_bright_as_their_points(name, seed):
    scene = awkward(name, seed)
    for what in MOVES[name]:
        image, derivative = filtered(name, scene, what)
        assert np.isfinite(image).all() and np.isfinite(derivative).all() and (image >= 0).all()
    assert image.mean() == pytest.approx(area_true(scene, scene.cameras["main"], 8).mean(), rel=0.03)
