"""What is said of a scene that is likely not meant as it stands; and that nothing is said of ordinary ones."""

import warnings
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from shared_surface_samples import box

import diffwhitted as dw
from diffwhitted._errors import SceneNote
from diffwhitted.formats.toml import scene_text
from diffwhitted.numerics._vector import Vec3
from diffwhitted.rendering._radiance_bound import radiance_bounds
from diffwhitted.tree import make_plan

ROOT = Path(__file__).parents[1]
PAINT = {"paint": dw.Material(k_d=0.5, k_h=0.2)}
LAMP = dw.PointLight((0, 0, 5), 1, name="key")
BALL = dw.Sphere("ball", (0, 0, 0), 1, "paint")


def scene(objects=(BALL,), materials=PAINT, lights=(LAMP,), cameras=None, **settings):
    return dw.Scene(objects=list(objects), materials=materials, lights=lights, cameras=cameras, **settings)


def noted(make) -> list[str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        make()
    assert all(one.category is SceneNote for one in caught)
    return [str(one.message) for one in caught]


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.toml")), ids=lambda path: path.name)
def test_nothing_is_said_of_the_examples(path):
    assert noted(lambda: dw.load_scene(path)) == []


# Bodies that are inside out

GLASS = {"glass": dw.Material(k_t=1, refractive_index=1.5), "paint": dw.Material(k_d=0.5)}


def bodies(*faces, material="glass"):
    return noted(lambda: scene([dw.Polygon(f"f{k}", face, material) for k, face in enumerate(faces)], GLASS))


def corners(low, high, turned=False):
    return [np.asarray(face.vertices) for face in box("b", low, high, "glass", turned)]


UNIT = ((-1, -1, -1), (1, 1, 1))


def test_a_body_of_glass_whose_faces_all_point_inwards():
    (note,) = bodies(*corners(*UNIT, turned=True))
    assert note.startswith(
        "objects 'f0', 'f1', 'f2', 'f3' and 2 more of material 'glass': seen from outside the closed"
    )
    assert "reverse the order of these vertices" in note
    triangles = [face[[0, *pair]] for face in corners(*UNIT, turned=True) for pair in ((1, 2), (2, 3))]
    assert "and 8 more" in bodies(*triangles)[0]


def test_faces_that_are_turned_against_their_neighbours():
    faces = corners(*UNIT)
    (note,) = bodies(*faces[:2], faces[2][::-1], *faces[3:])
    assert note.startswith("object 'f2' of material 'glass': seen from outside the closed body that it is part of")


def test_bodies_that_are_right_open_or_opaque():
    """Also far from the origin; a cavity within glass is turned against it; half of a body has no inside."""
    inner = corners((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), turned=True)
    for faces in (corners(*UNIT), [face + (100, 0, 0) for face in corners(*UNIT)], corners(*UNIT) + inner):
        assert bodies(*faces) == []
    assert bodies(*corners(*UNIT, turned=True)[:5]) == bodies(*corners(*UNIT, turned=True), material="paint") == []
    assert bodies([(0, 0, 0), (1, 0, 0), (0, 1, 0)]) == []


# Lamps that are near


@pytest.mark.parametrize(
    "thing, lamp, away",
    [
        (dw.Plane("wall", (0, 0, 2), 0, "paint"), (0, 0, 0.5), 0.5),
        (dw.Sphere("wall", (0, 0, -1), 1, "paint"), (0, 0, 0.5), 0.5),
        (dw.Sphere("wall", (0, 0, 0), 9, "paint"), (0, 0, 8.7), 0.3),
        (dw.Polygon("wall", [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], "paint"), (1, 2, 0.5), 0.5),
        (dw.Polygon("wall", [(-9, -9, 0), (0, -9, 0), (0, 9, 0), (-9, 9, 0)], "paint"), (0.3, 0, 0.4), 0.5),
        (dw.Plane("wall", (0, 0, 1), 0, "paint"), (0, 0, 2), None),
        (dw.Sphere("wall", (0, 0, 0), 9, "paint"), (0, 0, 2), None),
        (dw.Polygon("wall", [(-9, -9, 0), (0, -9, 0), (0, 9, 0), (-9, 9, 0)], "paint"), (3, 0, 0.5), None),
    ],
)
def test_a_lamp_nearer_than_where_its_fade_is_held(thing, lamp, away):
    def build(**fade):
        return noted(lambda: scene([thing], lights=[dw.PointLight(lamp, 1, name="key", **fade)]))

    notes = build(attenuation=(0, 0, 1))
    if away is None:
        assert notes == []
    else:
        said = f"light 'key' is {away:.3g} m from object 'wall': nearer than 1 m its attenuation is held at 1"
        assert len(notes) == 1 and notes[0].startswith(said)
        assert "nearer than 2 m" in build(attenuation=(0, 0, 0.25))[0]
    assert build() == build(attenuation=(1, 0, 1)) == build(attenuation=(0, 0, 1), attenuation_limit="none") == []


@pytest.mark.parametrize("distance, limit, brightness", [(0.5, None, 0.1), (0.5, "none", 0.4), (2, "none", 0.025)])
def test_the_inverse_square_near_a_lamp(distance, limit, brightness):
    """k_d / d**2 on a wall of k_d = 0.1, or k_d where it is held; and its derivative in the position, -2 k_d / d**3."""
    lamp = dw.PointLight((0, 0, distance), 1, attenuation=(0, 0, 1), attenuation_limit=limit)

    def arriving(z):
        zero = jnp.zeros(1)
        placed = dw.PointLight(jnp.stack([0.0 * z, 0.0 * z, z]), 1, attenuation=(0, 0, 1), attenuation_limit=limit)
        return 0.1 * jnp.broadcast_to(placed.arriving(Vec3(zero, zero, zero))[2].x, 1)[0]

    np.testing.assert_allclose(arriving(jnp.float64(distance)), brightness, rtol=1e-12)
    slope = 0.0 if limit is None else -2 * brightness / distance
    np.testing.assert_allclose(jax.grad(arriving)(jnp.float64(distance)), slope, atol=1e-12)
    assert (lamp.brightest() == (1 if limit is None else np.inf)).all()
    at_it = jax.tree.leaves(jax.jacfwd(lambda x: lamp.arriving(Vec3(x, x, x + distance)))(jnp.zeros(1)))
    assert all(np.isfinite(leaf).all() for leaf in at_it)


def test_the_bound_of_a_lamp_without_a_limit():
    """Infinite with the inverse square, 1 / a0 times its colour where the fade begins at a0."""
    near = dw.PointLight((0, 0, 5), 0.5, attenuation=(0.25, 0, 1), attenuation_limit="none")
    np.testing.assert_allclose(near.brightest(), 2.0)
    endless = dw.PointLight((0, 0, 5), 0.5, attenuation=(0, 1, 1), attenuation_limit="none")
    floor = dw.Plane("floor", (0, 0, 1), -2, "paint")
    made, camera = scene([BALL, floor], lights=[endless]), dw.Camera((0, 0, 9), (0, 0, 0), 40, 8, 6)
    assert np.isinf(radiance_bounds(made, camera, make_plan(made, camera))).any()


def test_a_limit_is_written_and_read_back():
    lamp = dw.PointLight((0, 0, 5), 1, attenuation=(0, 0, 1), attenuation_limit="none")
    again = dw.parse_scene(scene_text(scene(lights=[lamp])))
    assert again.lights[0].attenuation_limit == "none"
    assert "attenuation_limit" not in scene_text(scene())
    with pytest.raises(dw.SceneError, match='attenuation_limit = 3; allowed is "one" or "none"'):
        dw.PointLight((0, 0, 5), 1, attenuation=(0, 0, 1), attenuation_limit=3)  # pyright: ignore
    with pytest.raises(dw.SceneError, match="attenuation_limit without an attenuation"):
        dw.PointLight((0, 0, 5), 1, attenuation_limit="none")


def test_a_lamp_inside_an_object():
    inside = dw.PointLight((0, 0, 0.2), 1, name="key")
    outside = {"main": dw.Camera((0, 0, 9), (0, 0, 0), 40, 8, 6)}
    (note,) = noted(lambda: scene(lights=[inside, LAMP.__class__((0, 9, 0), 1)], cameras=outside))
    assert note.startswith("light 'key' is inside object 'ball', which lets no light out")
    room = {"main": dw.Camera((0, 0, 0.9), (0, 0, 0), 40, 8, 6)}
    assert noted(lambda: scene(lights=[inside], cameras=room)) == []
    assert noted(lambda: scene(materials={"paint": dw.Material(k_t=0.5)}, lights=[inside], cameras=outside)) == []


# Numbers


def test_numbers_that_look_like_codes_or_radians():
    (note,) = noted(lambda: scene(materials={"paint": dw.Material(k_d=(200, 30, 30))}))
    assert note.startswith("material 'paint': k_d = [200, 30, 30] sends on more light than arrives")
    (note,) = noted(lambda: scene(lights=[dw.PointLight((0, 0, 5), 255, name="key")]))
    assert note.startswith("light 'key': colour = [255, 255, 255] is 255 times the white of a display")
    (note,) = noted(lambda: scene(background=dw.ConstantBackground((128, 0, 0))))
    assert note.startswith("scene: background: colour = [128, 0, 0] is 128 times")
    (note,) = noted(lambda: scene(cameras={"main": dw.Camera((0, 0, 9), (0, 0, 0), 0.7, 8, 6)}))
    assert "it is in degrees, and 0.7 radians would be 40.11" in note
    bright = dw.PointLight((0, 0, 50), 2500, attenuation=(0, 0, 1))
    assert noted(lambda: scene(materials={"paint": dw.Material(k_d=1.5, k_a=3)}, lights=[bright])) == []


# Black pictures

VIEW = dw.Camera((0, 0, 9), (0, 0, 0), 40, 8, 6)
BLACK = {
    "no light": (scene(lights=[]), VIEW, "the scene has no light, no object reflects ambient light"),
    "dark lamps": (scene(lights=[dw.PointLight((0, 0, 5), 0)]), VIEW, "every light has colour 0"),
    "inside": (scene(), dw.Camera((0, 0, 0.5), (0, 0, 0), 40, 8, 6), "the camera is inside object 'ball'"),
    "behind": (scene(), dw.Camera((0, 0, 9), (0, 0, 20), 40, 8, 6), "every object is behind the camera"),
    "beside": (scene(), dw.Camera((0, 0, 9), (9, 0, 0), 20, 8, 6), "every object is outside the view"),
    "lamp inside": (
        scene(lights=[dw.PointLight((0, 0, 0), 1, name="key")]),
        VIEW,
        "light 'key' is inside object 'ball'",
    ),
    "no coefficient": (scene(materials={"paint": dw.Material()}), VIEW, "no object has k_a, k_d or k_h > 0"),
    "nothing": (scene([]), VIEW, "there is no object"),
    "turned away": (scene(lights=[dw.PointLight((0, 0, -9), 1)]), VIEW, "no light reaches what the camera sees"),
}


@pytest.mark.parametrize("name", BLACK)
def test_a_black_picture_says_why(name):
    made, camera, reason = BLACK[name]
    (note,) = noted(lambda: dw.render(made, camera))
    assert note.startswith(f"the picture is entirely black: {reason}")


def test_a_picture_with_light_says_nothing():
    assert noted(lambda: dw.render(scene(), VIEW)) == []
    assert noted(lambda: dw.render(scene(lights=[], background=dw.ConstantBackground((0, 0, 0.1))), VIEW)) == []
