"""Derivatives of the image: every row of the table of coefficients on two scenes, then light, shapes and camera.

Forward mode against central differences, reverse mode against forward mode, finite everywhere, and exactly zero
where nothing can change. All in float64 on 16 x 12 pixels.
"""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.tree import make_plan

WIDTH, HEIGHT = 16, 12


def glass_over_tiles():
    """Coloured glass and a mirror over a checkerboard; hard shadows, reflected highlights, a gradient behind."""
    return dw.Scene(
        objects=[
            dw.Sphere("ball", (-0.3, 0, 0), 1, "glass"),
            dw.Sphere("hidden", (0, 0, 9), 0.5, "hidden"),
            dw.Plane("floor", (0, 1, 0), -1, "floor"),
        ],
        materials={
            "glass": dw.Material(
                k_a=0.05,
                k_d=(0.1, 0.12, 0.2),
                k_h=(0.3, 0.2, 0.4),
                k_s=(0.15, 0.2, 0.25),
                k_t=(0.7, 0.6, 0.65),
                phong_exponent=20,
                refractive_index=1.4,
                extinction=(0.1, 0.2, 0.4),
                highlight="reflected",
            ),
            "floor": dw.Material(
                k_a=(0.1, 0.2, 0.3),
                k_d=0.6,
                k_h=0.2,
                k_s=0.3,
                phong_exponent=5,
                k_d_texture="tiles",
                k_a_texture="tiles",
            ),
            "hidden": dw.Material(k_d=0.5, k_s=0.5, highlight="off"),
            "spare": dw.Material(k_d=0.5),
        },
        textures={"tiles": dw.Checker(((0.9, 0.1, 0.1), (1, 1, 1)), 1.3, "xz")},
        lights=[dw.PointLight((3, 5, 4), (0.9, 0.8, 0.7))],
        cameras={"main": dw.Camera((0, 0.6, 5), (0, 0, 0), 40, WIDTH, HEIGHT)},
        background=dw.GradientBackground((0.5, 0.5, 0.4), (0.2, 0.4, 0.9)),
        max_depth=4,
        precision="float64",
    )


def glass_in_water():
    """A ball of glass in a ball of water behind a sheet of mirror; k_h follows k_s; tinted shadows of a light that
    fades.
    """
    return dw.Scene(
        objects=[
            dw.Sphere("drop", (0, 0, 0), 1.2, "water"),
            dw.Sphere("ball", (0.2, 0.1, 0.1), 0.6, "glass"),
            dw.Polygon("sheet", [(1, -2, -2), (4, -2, 0), (4, 2, 0), (1, 2, -2)], "sheet"),
        ],
        materials={
            "water": dw.Material(
                k_d=0.1, k_s=(0.2, 0.1, 0.1), k_t=0.8, phong_exponent=30, refractive_index=1.33, extinction=0.2
            ),
            "glass": dw.Material(
                k_a=0.1,
                k_d=(0.2, 0.1, 0.3),
                k_s=0.1,
                k_t=(0.7, 0.8, 0.6),
                phong_exponent=8,
                refractive_index=1.6,
                extinction=(0.3, 0.1, 0.2),
            ),
            "sheet": dw.Material(k_d=0.3, k_h=0.5, k_s=0.6, phong_exponent=50, highlight="off"),
        },
        lights=[dw.PointLight((-3, 4, 5), (1, 1, 1), attenuation=(0.2, 0.1, 0.02))],
        cameras={"main": dw.Camera((-0.5, 0.4, 6), (0.3, 0, 0), 35, WIDTH, HEIGHT)},
        background=dw.ConstantBackground((0.3, 0.5, 0.8)),
        max_depth=4,
        total_internal_reflection="whitted",
        shadows="tinted",
        precision="float64",
    )


OWN = {"abbe_number", "roughness", "height_scale", "emission"}
"""Have files of their own: `test_dispersion`, `test_gloss`, `test_wrinkles`, `test_radiosity_pictures`."""
SCENES = {"glass over tiles": glass_over_tiles, "glass in water": glass_in_water}

STEP = {"phong_exponent": 1e-3, "refractive_index": 1e-6}
"""Of the central difference, otherwise 1e-4. It is exact for what is linear (k_a, k_d, k_h), and off by step**2 for
products of k_s and k_t and for the exponent; the index needs a small one, or many rays cross an edge."""

TOLERANCE = {"phong_exponent": 1e-7, "extinction": 1e-7, "refractive_index": 1e-4}
"""Of the derivative, relative to its largest value, otherwise 1e-8: the rounding of a pixel, 1e-15, over the step."""

MUST_BE_ZERO = {
    "glass over tiles": {
        "spare.*": "no object is made of it",
        "hidden.*": "it stands behind the camera and no ray comes by",
        "floor.refractive_index": "no light passes through the floor",
        "floor.extinction": "no light passes through the floor",
    },
    "glass in water": {
        "sheet.k_h": "the highlight is off",
        "sheet.phong_exponent": "the highlight is off",
        "sheet.refractive_index": "no light passes through the sheet",
        "sheet.extinction": "no light passes through the sheet",
    },
}


def coefficients(scene):
    """Every coefficient that the scene's materials state, with a value a channel where the table allows a colour."""
    stated = {}
    for material, record in scene.materials.items():
        for row in dw.COEFFICIENTS:
            value = getattr(record, row.name)
            if value is not None and record.has(row.name):
                stated[f"{material}.{row.name}"] = jnp.broadcast_to(value, (3,)) if row.coloured else value
    return stated


NAMES = [(scene, name) for scene, make in SCENES.items() for name in coefficients(make())]


def tangent_of(name, value):
    """A random direction for one coefficient, the same for every test."""
    return np.random.default_rng(sum(map(ord, name))).uniform(0.5, 1.5, size=np.shape(value))


class Derivatives:
    """The two compiled programs of a function of many named values: with a forward derivative, and the reverse one."""

    def __init__(self, image, values):
        self.values = values
        self.weights = np.random.default_rng(8).normal(size=(HEIGHT, WIDTH, 3))
        self._still = jax.tree.map(jnp.zeros_like, values)
        self._forward = jax.jit(
            lambda values, tangents: jax.jvp(image, (values,), (tangents,)), compiler_options=SOON_COMPILED
        )
        self._reverse = jax.jit(
            lambda values, weights: jax.vjp(image, values)[1](weights)[0], compiler_options=SOON_COMPILED
        )

    def forward(self, name, tangent):
        return np.asarray(self._forward(self.values, self._still | {name: jnp.asarray(tangent)})[1])

    @functools.cached_property
    def reverse(self):
        return self._reverse(self.values, self.weights)

    def central(self, name, tangent, step):
        plus, minus = (
            self._forward(self.values | {name: self.values[name] + sign * step * tangent}, self._still)[0]
            for sign in (1, -1)
        )
        return np.asarray(plus - minus) / (2 * step)


@functools.cache
def derivatives(scene_name):
    scene = SCENES[scene_name]()
    values = coefficients(scene)
    plan = make_plan(scene, scene.cameras["main"], free=tuple(values))

    def image(values):
        changed = scene
        for name, value in values.items():
            changed = dw.replace_coefficient(changed, name, value)
        return dw.render(changed, scene.cameras["main"], plan=plan)

    return Derivatives(image, values)


def test_the_table_is_covered():
    """Every row of the table, as a value of its own or, for k_h, as a highlight that follows k_s."""
    for scene, make in SCENES.items():
        covered = {name.split(".")[1] for s, name in NAMES if s == scene and not must_be_zero(s, name)}
        assert covered >= {row.name for row in dw.COEFFICIENTS} - {"k_h", *OWN}, scene
        assert any(m.k_h is None for m in make().materials.values()), scene
    assert {name.split(".")[1] for _, name in NAMES} == {row.name for row in dw.COEFFICIENTS} - OWN


def must_be_zero(scene, name):
    return MUST_BE_ZERO[scene].get(name) or MUST_BE_ZERO[scene].get(name.split(".")[0] + ".*")


@pytest.mark.parametrize("scene, name", NAMES)
def test_coefficient_of_a_material(scene, name):
    """One row of the table on one scene; one that moves rays, in the pixels where differences over h and 2 h agree."""
    row = next(r for r in dw.COEFFICIENTS if r.name == name.split(".")[1])
    of, step = derivatives(scene), STEP.get(row.name, 1e-4)
    tangent = tangent_of(name, of.values[name])
    forward = of.forward(name, tangent)
    assert np.isfinite(forward).all() and np.isfinite(of.reverse[name]).all()
    np.testing.assert_allclose((of.reverse[name] * tangent).sum(), (of.weights * forward).sum(), rtol=1e-9, atol=1e-12)
    if must_be_zero(scene, name):
        assert (forward == 0).all() and (of.reverse[name] == 0).all()
        return
    size = np.abs(forward).max()
    assert size > 1e-3
    central, wider = (of.central(name, tangent, h) for h in (step, 2 * step))
    smooth = np.abs(central - wider).max(axis=-1) < TOLERANCE["refractive_index"] * size
    assert smooth.all() if not row.moves_rays else smooth.mean() > 0.9
    np.testing.assert_allclose(forward[smooth], central[smooth], atol=TOLERANCE.get(row.name, 1e-8) * size, rtol=0)


@pytest.mark.parametrize(
    "scene, name", [(s, n) for s, n in NAMES if n.split(".")[1] in {r.name for r in dw.COEFFICIENTS if r.coloured}]
)
def test_a_channel_of_a_coefficient_changes_that_channel_only(scene, name):
    forward = derivatives(scene).forward(name, np.array([0.0, 1.0, 0.0]))
    assert (forward[..., [0, 2]] == 0).all()
    assert (forward[..., 1] != 0).any() or must_be_zero(scene, name)


# Coefficients that are zero now


def mirror_floor(**coefficients):
    """A floor that sends nothing back but what k_s and k_t let in: the sky above, the sky below."""
    return dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0), -1, "floor")],
        materials={"floor": dw.Material(**({"k_s": 0.0, "k_t": 0.0, "k_h": 0.0} | coefficients))},
        lights=[dw.PointLight((0, 4, 0), (1, 1, 1))],
        cameras={"main": dw.Camera((0, 0, 0), (0, -2, -1), 40, WIDTH, HEIGHT)},
        background=dw.GradientBackground((0.9, 0.5, 0.1), (0.1, 0.3, 0.8)),
        precision="float64",
    )


def sky_seen(scene, mirrored):
    """What the floor lets in along straight and along mirrored rays."""
    camera = scene.cameras["main"]
    ray = camera.rays(*camera.place(jnp.arange(WIDTH * HEIGHT), jnp.asarray([0.5, 0.5])))
    assert (ray.direction.y < 0).all()
    height = 0.5 * (1 + np.asarray(ray.direction.y) * (-1 if mirrored else 1))[:, None]
    background = scene.background
    return ((1 - height) * np.asarray(background.bottom) + height * np.asarray(background.top)).reshape(
        HEIGHT, WIDTH, 3
    )


def test_derivative_at_exactly_zero():
    """In reverse under `jit` with a plan that names the coefficients, and forward without any plan: the sky that they
    let in.
    """
    scene, names = mirror_floor(), ("floor.k_s", "floor.k_t")
    camera = scene.cameras["main"]
    plan = make_plan(scene, camera, free=names)

    def image(values, plan=None):
        changed = scene
        for name, value in zip(names, values, strict=True):
            changed = dw.replace_coefficient(changed, name, value)
        return dw.render(changed, camera, plan=plan)

    expected = [sky_seen(scene, mirrored=True), sky_seen(scene, mirrored=False)]
    for k, tangent in enumerate(np.eye(2)):
        value, slope = jax.jvp(image, (jnp.zeros(2),), (jnp.asarray(tangent),))
        assert (value == 0).all()
        np.testing.assert_allclose(slope, expected[k], atol=1e-12)
    gradient = jax.jit(jax.grad(lambda values: image(values, plan).sum()), compiler_options=SOON_COMPILED)(jnp.zeros(2))
    np.testing.assert_allclose(gradient, [e.sum() for e in expected], rtol=1e-12)
    # A plan made for zeros leaves the effects out: the derivative is gone with them.
    assert not make_plan(scene, camera).effects.branching


# Light, shapes and camera


def lens():
    """One ball of glass that fills the picture: nothing in it has an edge, however it moves."""
    return dw.Scene(
        objects=[dw.Sphere("ball", (0.1, -0.1, 0), 1, "glass")],
        materials={
            "glass": dw.Material(k_a=0.1, k_d=0.4, k_h=0.5, k_s=0.3, k_t=0.6, phong_exponent=12, refractive_index=1.4)
        },
        lights=[dw.PointLight((2, 3, 8), (0.9, 0.8, 0.7), attenuation=(0.5, 0.05, 0.01))],
        cameras={"main": dw.Camera((0, 0.2, 6), (0, 0, 0), 9, WIDTH, HEIGHT)},
        background=dw.GradientBackground((0.9, 0.5, 0.1), (0.1, 0.3, 0.8)),
        max_depth=4,
        precision="float64",
    )


PARTS = {
    "centre": lambda s: s.objects[0].centre,
    "radius": lambda s: s.objects[0].radius,
    "refractive_index": lambda s: s.materials["glass"].refractive_index,
    "light position": lambda s: s.lights[0].position,
    "light colour": lambda s: s.lights[0].colour,
    "attenuation": lambda s: s.lights[0].attenuation,
    "background": lambda s: s.background.top,
    "ambient": lambda s: s.ambient,
    "look_from": lambda s: s.cameras["main"].look_from,
    "look_at": lambda s: s.cameras["main"].look_at,
    "up": lambda s: s.cameras["main"].up,
    "vfov_deg": lambda s: s.cameras["main"].vfov_deg,
}


@functools.cache
def derivatives_of_parts():
    scene = lens()
    plan = make_plan(scene, scene.cameras["main"])

    def image(values):
        changed = eqx.tree_at(lambda s: [PARTS[name](s) for name in values], scene, list(values.values()))
        return dw.render(changed, changed.cameras["main"], plan=plan)

    return Derivatives(image, {name: part(scene) for name, part in PARTS.items()})


@pytest.mark.parametrize("name", PARTS)
def test_light_shape_and_camera(name):
    """Rays move, and every pixel agrees: the scene has no edge."""
    of = derivatives_of_parts()
    tangent = tangent_of(name, of.values[name])
    forward, central = of.forward(name, tangent), of.central(name, tangent, 1e-5)
    size = np.abs(central).max()
    assert size > 1e-4 and np.isfinite(of.reverse[name]).all()
    np.testing.assert_allclose(forward, central, atol=1e-6 * size, rtol=0)
    np.testing.assert_allclose((of.reverse[name] * tangent).sum(), (of.weights * forward).sum(), rtol=1e-9)


# vmap


def ball_and_floor():
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint"), dw.Plane("floor", (0, 1, 0), -1, "floor")],
        materials={"paint": dw.Material(k_d=0.5, k_h=0.3, k_s=0.2, phong_exponent=9), "floor": dw.Material(k_d=0.7)},
        lights=[dw.PointLight((2, 4, 3), 1.0)],
        cameras={"main": dw.Camera((0, 0.5, 5), (0, 0, 0), 40, WIDTH, HEIGHT)},
        background=dw.ConstantBackground((0.2, 0.3, 0.4)),
        max_depth=2,
        precision="float64",
    )


def with_k_s(scene, value):
    return dw.replace_coefficient(scene, "paint.k_s", value), scene.cameras["main"]


def with_light_at(scene, position):
    return eqx.tree_at(lambda s: s.lights[0].position, scene, position), scene.cameras["main"]


def with_camera_at(scene, position):
    return scene, eqx.tree_at(lambda c: c.look_from, scene.cameras["main"], position)


@pytest.mark.parametrize(
    "changed, values",
    [
        (with_k_s, np.array([0.0, 0.2, 0.9])),
        (with_light_at, np.array([(2.0, 4.0, 3.0), (-3.0, 2.0, 1.0)])),
        (with_camera_at, np.array([(0.0, 0.5, 5.0), (3.0, 2.0, 3.0)])),
    ],
    ids=["material", "light", "camera"],
)
def test_vmap_equals_a_loop(changed, values):
    scene = ball_and_floor()
    plan = make_plan(scene, scene.cameras["main"])

    def image(value):
        changed_scene, camera = changed(scene, value)
        return dw.render(changed_scene, camera, plan=plan)

    together = jax.jit(jax.vmap(image), compiler_options=SOON_COMPILED)(jnp.asarray(values))
    one_by_one = np.stack([image(jnp.asarray(value)) for value in values])
    np.testing.assert_allclose(together, one_by_one, atol=1e-12)
    assert np.abs(one_by_one[0] - one_by_one[1]).max() > 0.05
