"""Pictures with light between diffuse surfaces, and fits of them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from test_radiosity import RED, room

import diffwhitted as dw
import fitting
from diffwhitted._errors import SceneError
from diffwhitted.records import changed
from diffwhitted.tree import decide_effects

TOML = """
[scene]
radiosity = { patches = 40, solver = "direct" }

[[camera]]
name = "main"
look_from = [0.5, 0.5, 0.9]
look_at = [0.4, 0.3, 0]
vfov_deg = 60
width = 12
height = 12

[[material]]
name = "wall"
k_d = [0.5, 0.25, 0.8]
emission = [1, 2, 0.5]

[[object]]
name = "box"
type = "box"
minimum = [0, 0, 0]
maximum = [1, 1, 1]
material = "wall"
"""


def rendered(scene: dw.Scene, **options) -> np.ndarray:
    return np.asarray(dw.render(scene, scene.cameras["main"], **options))


@pytest.fixture(scope="module")
def furnace():
    return dw.parse_scene(TOML)


def test_inside_of_a_furnace(furnace):
    """Emission + k_d H/pi = emission / (1 - k_d), whatever is looked at."""
    image = rendered(furnace)
    assert image.reshape(-1, 3) == pytest.approx(np.tile([2, 2 / 0.75, 2.5], (144, 1)), rel=1e-4)


def test_a_file_keeps_it(furnace, tmp_path):
    dw.save_scene(furnace, tmp_path / "scene.toml")
    again = dw.load_scene(tmp_path / "scene.toml")
    assert again.radiosity == furnace.radiosity
    assert again.materials["wall"].emission == pytest.approx([1, 2, 0.5])


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ('{ patches = 0, solver = "direct" }', "patches = 0"),
        ('{ patches = 40, solver = "lu" }', "solver"),
        ("{ patch = 40 }", "patch"),
        ("7", "radiosity"),
    ],
)
def test_a_wrong_key_is_named(key, said):
    with pytest.raises(SceneError, match=said):
        dw.parse_scene(TOML.replace('{ patches = 40, solver = "direct" }', key))


def test_it_stands_in_the_place_of_ambient_light(furnace):
    lit = changed(furnace, materials={"wall": dw.Material(k_d=0.5, k_a=1.0)})
    by_name = {decision.name: decision for decision in decide_effects(lit)}
    assert (by_name["ambient"].on, by_name["ambient"].why) == (False, "radiosity stands in its place")
    assert by_name["radiosity"].why == "radiosity, object 'box': wall.k_d = 0.5"
    assert {row.name for row in decide_effects(changed(lit, radiosity=None)) if row.on} >= {"ambient"}


def test_emission_needs_no_radiosity(furnace):
    image = rendered(changed(furnace, radiosity=None))
    assert image.reshape(-1, 3) == pytest.approx(np.tile([1, 2, 0.5], (144, 1)))


def test_a_mirror_sees_it():
    """Parallel rays that a mirror sends back see what those that are sent the other way see, left for right."""
    plain = room(size=8)
    mirror = dw.Polygon("mirror", [(-1, -1, 2.6), (-1, 3, 2.6), (3, 3, 2.6), (3, -1, 2.6)], "mirror")
    scene = changed(
        plain,
        objects=(*plain.objects, mirror),
        materials=plain.materials | {"mirror": dw.Material(k_s=1.0)},
        max_depth=2,
    )
    seen, mirrored = (
        np.asarray(dw.render(scene, dw.OrthographicCamera((1, 1, 2.5), (1, 1, at), 1.9, 8, 8))) for at in (0, 9)
    )
    assert seen.std() > 0.05
    assert mirrored[:, ::-1] == pytest.approx(seen, rel=1e-9)


def lit_by_a_point(radiosity=None, **colours) -> dw.Scene:
    """The walls of the room alone, nothing in between."""
    whole = room(size=12, **colours)
    lamp = dw.PointLight((1, 1.7, 1), (0.9, 0.8, 0.7), name="lamp")
    return changed(
        whole,
        objects=whole.objects[:5],
        materials={name: whole.materials[name] for name in ("white", "red", "green")},
        lights=(lamp,),
        radiosity=None if radiosity is None else changed(room().radiosity, patches=radiosity),
        ambient=np.zeros(3),
    )


@pytest.mark.slow
def test_derivatives_of_pictures():
    """In the colours of a wall and of a lamp, forward against differences and against reverse."""
    scene = lit_by_a_point(40)
    camera, step = scene.cameras["main"], 1e-5
    plan = dw.plan(scene, camera)
    along = jnp.asarray([1.0, -0.5, 0.3]), jnp.asarray([0.2, 0.1, -0.3])

    @jax.jit
    def picture(k, colour):
        lit = dw.replace_parameter(dw.replace_coefficient(scene, "red.k_d", k), "light.lamp.colour", colour)
        return dw.render(lit, camera, plan=plan)

    at = jnp.asarray(RED), jnp.asarray([0.9, 0.8, 0.7])
    image, slope = jax.jvp(picture, at, along)
    one, other = (picture(*(a + sign * step * t for a, t in zip(at, along, strict=True))) for sign in (1, -1))
    assert np.isfinite(image).all()
    assert np.asarray(slope) == pytest.approx(np.asarray(one - other) / (2 * step), rel=1e-5, abs=1e-6)
    weights = jax.random.normal(jax.random.key(0), image.shape, image.dtype)
    back = jax.vjp(picture, *at)[1](weights)
    assert sum(float((b * t).sum()) for b, t in zip(back, along, strict=True)) == pytest.approx(
        float((weights * slope).sum()), rel=1e-8
    )


@pytest.mark.slow
def test_a_fit_accounts_for_light_between_walls():
    """Wall colours from a picture made with four times as many patches; without radiosity they are far off."""
    target = rendered(lit_by_a_point(600))
    grey = {name: (0.4, 0.4, 0.4) for name in ("red", "green")}
    off = {}
    for patches in (150, None):
        start = lit_by_a_point(patches, white=0.5, **grey)
        result = fitting.fit(start, target, free=["white.k_d", "red.k_d", "green.k_d"])
        found = {"white.k_d": 0.7} | {f"red.k_d.{c}": v for c, v in zip("rgb", RED, strict=True)}
        off[patches] = max(abs(result[name].value / true - 1) for name, true in found.items())
    assert off[150] < 0.01
    assert off[None] > 0.2
    assert result.status == "misfit"


def test_shots_by_single_lamps_are_refused():
    scene = lit_by_a_point(20)
    shot = dw.Shot("left", "picture.exr", lights=["lamp"])
    with pytest.raises(SceneError, match="lights with radiosity"):
        dw.Scene(
            objects=scene.objects, materials=scene.materials, lights=scene.lights, cameras=scene.cameras, shots=[shot],
            radiosity={"patches": 20},
        )  # fmt: skip
