"""Scenes of "The Ray Tracer Challenge" in YAML: the book's own numbers, and what is refused."""

import numpy as np
import pytest
from scene_reader import reader

import diffwhitted as dw
from diffwhitted._errors import SceneError

CAMERA = "- {add: camera, width: 1, height: 1, field-of-view: 0.01, from: %s, to: %s, up: [0, 1, 0.1]}\n"
WORLD = """
- {add: light, at: [-10, 10, -10], intensity: [1, 1, 1]}
- add: sphere
  material: {color: [0.8, 1.0, 0.6], diffuse: 0.7, specular: 0.2}
- add: sphere
  transform: [[scale, 0.5, 0.5, 0.5]]
"""
FLOOR = """
- {add: plane, transform: [[translate, 0, -1, 0]], material: {reflective: 0.5}}
"""
POOL = """
- add: plane
  transform: [[translate, 0, -1, 0]]
  material: {reflective: 0.5, transparency: 0.5, refractive-index: 1.5}
- {add: sphere, transform: [[translate, 0, -3.5, -0.5]], material: {color: [1, 0, 0], ambient: 0.5}}
"""
BOOK = """
- add: camera
  width: 100
  height: 50
  field-of-view: 1.0471975512
  from: [0, 1.5, -5]
  to: [0, 1, 0]
  up: [0, 1, 0]
- add: light
  at: [-10, 10, -10]
  intensity: [1, 1, 0.5]
- define: white
  value: {color: [1, 1, 1], diffuse: 0.7, specular: 0.0, reflective: 0.1}
- define: blue
  extend: white
  value: {color: [0.5, 0.8, 0.9]}
- define: small
  value:
    - [scale, 0.5, 0.5, 0.5]
    - [translate, 0, 1, 0]
- define: pair
  value:
    add: group
    transform: [[translate, 10, 0, 0]]
    children:
      - {add: cube, material: white}
      - {add: cone, min: -1, max: 2, closed: true}
- add: plane
  material:
    pattern: {type: checkers, colors: [[0.2, 0.2, 0.2], [0.8, 0.8, 0.4]], transform: [[scale, 2, 2, 2]]}
- {add: sphere, transform: [small, [rotate-z, 1.5707963267948966]], material: blue}
- {add: pair, transform: [[scale, 2, 2, 2]], material: blue}
- {add: cylinder, material: {transparency: 0.5, reflective: 0.25, refractive-index: 1.5}}
- {add: triangle, p1: [0, 0, 0], p2: [1, 0, 0], p3: [0, 1, 2], shadow: false}
- {add: union, left: a, right: b}
"""


@pytest.fixture
def read(tmp_path):
    """The scene of a text, and the notes on it."""
    return reader(tmp_path / "scene.yml")


@pytest.mark.parametrize(
    "world, eye, at, published",
    [
        (WORLD, "[0, 0, -5]", "[0, 0, 0]", [0.38066, 0.47583, 0.2855]),
        (WORLD + FLOOR, "[0, 0, -3]", "[0, -1, -2]", [0.87677, 0.92436, 0.82918]),
        (WORLD + POOL, "[0, 0, -3]", "[0, -1, -2]", [0.93391, 0.69643, 0.69243]),
    ],
)
def test_the_colours_of_the_book(read, world, eye, at, published):
    """Chapters 7 ("shading an intersection") and 11 ("shade_hit with a reflective material", and with one that is
    transparent as well, of which a hundredth of the light is shared out another way).
    """
    scene, _ = read(CAMERA % (eye, at) + world)
    image = np.asarray(dw.render(scene, scene.cameras["main"]))[0, 0]
    np.testing.assert_allclose(image, published, atol=6e-3 if POOL in world else 2e-4)


def test_each_entry_becomes_what_it_says(read):
    scene, notes = read(BOOK, precision="float64")
    kinds = [type(thing).__name__ for thing in scene.objects]
    assert kinds == ["Plane", "Sphere", "Box", "Cone", "Cone", "Quadric", "Polygon"]
    plane, ball, cube, below, above, tube, triangle = scene.objects
    # z is turned round, scale comes before the shift, and that before the turn by a quarter.
    np.testing.assert_allclose(ball.centre, [-1, 0, 0], atol=1e-12)
    assert float(ball.radius) == 0.5
    np.testing.assert_allclose([cube.minimum, cube.maximum], [[18, -2, -2], [22, 2, 2]])
    np.testing.assert_allclose([below.base, below.top, above.top], [[20, -2, 0], [20, 0, 0], [20, 4, 0]])
    assert (float(below.base_radius), float(above.top_radius), below.capped) == (2, 4, True)
    np.testing.assert_allclose(triangle.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, -2]])
    # What a group wears is that of its children without a material of their own.
    assert (ball.material, cube.material, below.material) == ("blue", "white", "blue")
    blue, board = scene.materials["blue"].values, scene.materials[plane.material]
    np.testing.assert_allclose(blue["k_d"], np.multiply(0.7, [0.5, 0.8, 0.9]))
    np.testing.assert_allclose(blue["k_a"], np.multiply(0.1, [0.5, 0.8, 0.9]))
    assert (float(blue["k_h"]), float(blue["k_s"]), scene.materials["blue"].highlight) == (0, 0.1, "reflected")
    # floor(x / 2) + floor(-z / 2) is even where floor(x / 2) + floor(z / 2) is odd.
    tiles = scene.textures[board.k_d_texture]
    np.testing.assert_allclose(tiles.colours * board.k_d, np.multiply(0.9, [[0.8, 0.8, 0.4], [0.2, 0.2, 0.2]]))
    assert (float(tiles.size), tiles.axes) == (2, "xz") and not np.any(tiles.corner)
    glass = scene.materials[tube.material].values
    assert [float(glass[key]) for key in ("k_t", "k_s", "refractive_index")] == [0.5, 0.25, 1.5]
    assert scene.materials[tube.material].fresnel == "schlick"
    # The angle is that of the longer side.
    camera = scene.cameras["main"]
    assert float(camera.vfov_deg) == pytest.approx(np.degrees(2 * np.arctan(np.tan(np.pi / 6) / 2)))
    np.testing.assert_allclose([camera.look_from, camera.look_at], [[0, 1.5, 5], [0, 1, 0]])
    np.testing.assert_allclose(scene.ambient, [1, 1, 0.5])
    assert (scene.max_depth, scene.shadows, scene.total_internal_reflection) == (6, "opaque", "whitted")
    said = " ".join(notes)
    for words in ("shadow: false of shape", 'left out: set of solids "union"', "1 - F reflective"):
        assert words in said


BOMB = "- &a0 [translate, 0, 0, 0]\n" + "".join(f"- &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 40))


@pytest.mark.parametrize(
    "text, said",
    [
        ("", "the file is empty"),
        ("- add: [", "line 1: broken YAML"),
        ("{add: sphere}", "line 1: the file is no list"),
        ("- add: sphere\n- add: ball", "line 2: add: 'ball'; allowed is camera, light, group, sphere"),
        ("- add: sphere\n  radius: 1", "line 2: unknown key 'radius' of a sphere"),
        ("- add: sphere\n  add: cube", "line 2: add is stated twice"),
        ("- add: sphere\n  material: {color: [1, .nan, 1]}", "line 2: color = '.nan' is no number"),
        ("- add: sphere\n  material: {colour: [1, 1, 1]}", "unknown key 'colour' of a material"),
        ("- add: sphere\n  material: paint", "material 'paint' is not defined above"),
        ("- add: sphere\n  transform: [[turn, 1]]", "line 2: a step 'turn'"),
        ("- add: sphere\n  transform: [[scale, 1, 0, 1]]", "line 1: object 'sphere': matrix makes the object flat"),
        ("- &a\n  add: group\n  children: [*a]", "groups within groups more than 32 deep"),
        ("- define: a\n  value: &t [*t]\n- {add: sphere, transform: a}", "or of itself"),
        ("- define: a\n  extend: a\n  value: {}", "'a' is not defined above"),
        (BOMB + "- {add: sphere, transform: [*a39]}", "an entry"),
        ("- define: t\n  value:\n" + "    " + BOMB.replace("\n", "\n    ") + "\n- {add: sphere, transform: t}",
         "a transform of more than 1000 steps"),
        ("[" * 5000, "too deep"),
        (b"\xff\xfe\x00", "not text"),
        ("- add: camera", "the camera has no width"),
        ("- {add: light, at: [0, 0, 0]}", "the light has no intensity"),
        ("- {add: obj, file: ../secret.obj}", "an OBJ file in the folder"),
        ("- {add: light, at: [0, 0, 0], intensity: [1, 1, 1]}", "no shape in it"),
        ("- define: a\n  value: {<<: {b: 1}}\n- {add: sphere, material: a}", "merged keys"),
    ],
)  # fmt: skip
def test_hostile_files_are_refused_by_line(read, text, said):
    with pytest.raises(SceneError, match="scene.yml") as error:
        read(text)
    assert said in str(error.value)
