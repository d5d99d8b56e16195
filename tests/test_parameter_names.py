"""Names of numbers: what is said of wrong ones, which may be free and how, and in which bounds."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

import diffwhitted as dw
from diffwhitted.numerics._safe import normalise
from diffwhitted.numerics._vector import vec3
from diffwhitted.records import Row, read_rows
from diffwhitted.scene import LIGHTS, AbstractLight
from diffwhitted.tree import idle
from fitting import FitError
from fitting.problem._free_names import free_parameters
from fitting.problem._unknowns import insert, list_unknowns, start_values, values_in
from references.one_of_each import one_of_each


def found(name: str) -> dw.Parameter:
    return next(parameter for parameter in dw.parameters(one_of_each()) if parameter.name == name)


def test_a_corner_does_not_leave_the_plane_of_its_polygon():
    with pytest.raises(dw.SceneError, match="'board': vertices are not in one plane"):
        dw.replace_parameter(one_of_each(), "object.board.vertices.1.z", -1.0)
    triangle = dw.replace_parameter(one_of_each(), "object.sail.vertices.1.z", -0.5)
    assert dw.parameter_value(triangle, "object.sail.vertices.1.z") == -0.5


@pytest.mark.parametrize(
    "name, words",
    [
        ("light.lmp.colour", ["no light 'lmp'", "lamp, sun", "Did you mean 'lamp'?"]),
        ("light.lamp.color", ["light 'lamp'", "'color'", "Did you mean 'colour'?"]),
        ("light.lamp.colour.x", ["no component 'x'", "r, g, b"]),
        ("light.sun.attenuation", ["light 'sun'", "no number 'attenuation'"]),
        ("lights.lamp.colour", ["no material 'lights.lamp'", "Did you mean 'light.lamp.colour'?"]),
        ("object.ball", ["object 'ball'", "which of its numbers?", "centre, radius"]),
        ("object.bal.radius", ["no object 'bal'", "Did you mean 'ball'?"]),
        ("camera.main.vfov", ["camera 'main'", "'vfov'", "Did you mean 'vfov_deg'?"]),
        ("texture.tiles.colours.2.r", ["no component '2.r'", "0.r"]),
        ("scene.ambience", ["the scene", "Did you mean 'ambient'?"]),
        ("background.colour", ["the background", "bottom, top"]),
        ("glazed.k_h.r", ["in the scene k_h is one number", "k_h = [0.3, 0.3, 0.3]"]),
        ("glazed.phong_exponent.r", ["it is one number"]),
        ("glased.k_d", ["no material 'glased'", "Did you mean 'glazed'?"]),
        ("glazed.k_q", ["no coefficient 'k_q'"]),
        ("k_d", ["MATERIAL.COEFFICIENT", "light, object, camera, texture, shot, scene, background"]),
    ],
)
def test_a_wrong_name_is_told_the_nearest(name, words):
    for call in (dw.parameter_value, lambda scene, name: dw.replace_parameter(scene, name, 1.0)):
        with pytest.raises(dw.SceneError) as caught:
            call(one_of_each(), name)
        for word in words:
            assert word in str(caught.value)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "name, value, words",
    [
        ("object.ball.radius", -1.0, ["object 'ball'", "radius = -1", "> 0"]),
        ("light.lamp.colour", (-0.1, 0, 0), ["light 'lamp'", "colour", ">= 0"]),
        ("light.sun.direction", (0, 0, 0), ["light 'sun'", "direction", "any vector but zero"]),
        ("camera.main.vfov_deg", 180, ["camera 'main'", "vfov_deg = 180", "between 0 and 180"]),
        ("camera.main.up", (0, 0, 0), ["camera 'main'", "line of sight"]),
        ("object.sail.vertices", [(0, 0, 0), (1, 0, 0), (2, 0, 0)], ["object 'sail'", "no area"]),
        ("object.sail.vertices", [(0, 0, 0), (1, 0, 0)], ["object 'sail'", "shape"]),
        ("scene.ambient", (1, -1, 1), ["scene", "ambient", ">= 0"]),
        ("texture.tiles.size", 0.0, ["texture 'tiles'", "size = 0", "> 0"]),
        ("light.lamp.position.x", "left", ["light 'lamp'", "position.x = 'left'"]),
        ("light.lamp.colour.r", -1, ["light 'lamp'", "colour", ">= 0"]),
        ("light.lamp.position", "left", ["light 'lamp'", "position = 'left'"]),
    ],
)
def test_a_value_that_is_not_allowed_is_named(name, value, words):
    with pytest.raises(dw.SceneError) as caught:
        dw.replace_parameter(one_of_each(), name, value)
    for word in words:
        assert word in str(caught.value)


def test_the_old_names_of_functions_take_all_names():
    scene = one_of_each()
    changed = dw.replace_coefficient(scene, "light.lamp.position.x", 1.5)
    assert dw.coefficient_value(changed, "light.lamp.position").tolist() == [1.5, 3.5, 3]
    assert dw.parameter_value(scene, "material.glazed.k_s") == dw.coefficient_value(scene, "glazed.k_s") == 0.15


def test_a_material_called_like_a_family_and_names_with_dots():
    scene = dw.Scene(
        objects=[dw.Sphere("a.b", (0, 0, 0), 1, "light"), dw.Sphere("c", (3, 0, 0), 1, "x.y")],
        materials={"light": dw.Material(k_d=0.25), "x.y": dw.Material(k_d=(0.1, 0.2, 0.3))},
        lights=[dw.DirectionalLight((0, 0, 1), 1, name="key")],
    )
    assert dw.parameter_value(scene, "material.light.k_d") == dw.parameter_value(scene, "light.k_d") == np.float32(0.25)
    assert dw.parameter_value(scene, "x.y.k_d.b") == np.float32(0.3)
    assert dw.parameter_value(scene, "light.key.colour").shape == (3,)
    with pytest.raises(dw.SceneError, match="name of the object 'a.b' has a dot"):
        dw.parameter_value(scene, "object.a.b.radius")
    with pytest.raises(dw.SceneError, match="light 'my.lamp': allowed is a name without a dot"):
        dw.Scene(objects=[], materials={}, lights=[dw.PointLight((0, 1, 0), 1, name="my.lamp")])


def free(*patterns, **how):
    return free_parameters(one_of_each(), patterns, **how)


def test_stars_match_materials_unless_a_family_word_comes_first():
    names, passed_over = free("*")
    assert {name.partition(".")[0] for name in names} == {"glazed", "matte", "floor"}
    assert {name.partition(".")[0] for name, _ in passed_over} == {"glazed", "matte", "floor", "spare"} - {"glazed"}
    assert free("*.k_d")[0] == ("glazed.k_d", "matte.k_d", "floor.k_d") == free("material.*.k_d")[0]
    assert free("light.*.colour")[0] == ("light.lamp.colour", "light.sun.colour")
    assert free("object.*.centre.x")[0] == ("object.ball.centre.x",)
    edges = "texture.print.origin", "texture.print.edge_u", "texture.print.edge_v"
    assert free("texture.*")[0] == ("texture.tiles.colours", "texture.tiles.size", *edges)
    assert free("glazed.k_d.r", "glazed.k_d.b")[0] == ("glazed.k_d.r", "glazed.k_d.b")
    assert free("glazed.k_d.r", "glazed.k_d")[0] == ("glazed.k_d",)
    assert free("camera.*.vfov_deg", cameras={"main"})[0] == ("camera.main.vfov_deg",)


@pytest.mark.parametrize(
    "name, words",
    [
        ("glazed.k_h.r", ["in the scene k_h is one number", "[0.3, 0.3, 0.3]"]),
        ("light.sun.direction.x", ["not free by itself", "light.sun.direction.u, light.sun.direction.v"]),
        ("object.board.vertices.1.x", ["not free by itself", "object.board.vertices.0.u"]),
        ("texture.unworn.size", ["no object wears texture 'unworn'"]),
        ("spare.k_d", ["no object is made of 'spare'"]),
        ("light.lamp.size", ["light 'lamp'", "no number 'size'"]),
        ("light.*.size", ["light '*'"]),
        ("lamp.colour", ["matches no coefficient", "begin with one of light"]),
    ],
)
def test_what_cannot_be_free_is_said_with_what_can(name, words):
    with pytest.raises(FitError) as caught:
        free(name)
    for word in words:
        assert word in str(caught.value)


def test_what_no_picture_can_show_is_idle():
    scene = one_of_each()
    assert "takes none of the pictures" in idle(scene, found("camera.side.vfov_deg"), cameras=("main",))
    assert idle(scene, found("camera.side.vfov_deg")) is None
    dark = dw.replace_parameter(scene, "light.lamp.colour", 0.0)
    assert "light.lamp.colour = 0" in idle(dark, found("light.lamp.position"))
    assert idle(dark, found("light.lamp.position"), free=["light.lamp.colour"]) is None
    bare = dw.replace_parameter(scene, "scene.ambient", 0.0)
    assert "ambient = 0" in idle(bare, found("matte.k_a"))
    assert idle(bare, found("matte.k_a"), free=["scene.ambient"]) is None


@pytest.mark.parametrize(
    "name, ways, expected",
    [
        ("light.sun.direction", ("u", "v"), (3.0, -2.0)),
        ("object.ground.normal", ("u", "v"), (-4.0, 1.0)),
        ("camera.main.look_at", ("u", "v"), (2.0, 5.0)),
        ("camera.main.up", ("roll",), (7.0,)),
        ("object.board.vertices", tuple(f"{k}.{way}" for k in range(4) for way in "uv"), np.linspace(-0.1, 0.1, 8)),
    ],
)
def test_angles_and_moves_in_a_plane_come_back_as_they_went_in(name, ways, expected):
    """A turn keeps the length and is as large as its two angles say; a polygon stays flat."""
    scene, parameter = one_of_each(), found(name)
    unknowns = list_unknowns(scene, [name])
    assert tuple(u.component for u in unknowns) == ways
    np.testing.assert_allclose(start_values(scene, unknowns), 0, atol=1e-9)
    turned = insert(scene, unknowns, jnp.asarray(expected))
    np.testing.assert_allclose(values_in(scene, unknowns, turned), expected, atol=1e-9)
    before, after = (np.asarray(dw.parameter_value(s, name)) for s in (scene, turned))
    if name == "camera.main.look_at":
        origin = np.asarray(dw.parameter_value(scene, "camera.main.look_from"))
        before, after = before - origin, after - origin
    if len(ways) <= 2:
        assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(before))
    if len(ways) == 2:
        cosine = before @ after / (before @ before)
        assert np.rad2deg(np.arccos(cosine)) == pytest.approx(np.hypot(*expected))
    if parameter.row.kind == "vectors":
        np.testing.assert_allclose(np.linalg.det([b - after[0] for b in after[1:]]), 0, atol=1e-12)


@pytest.mark.parametrize(
    "name, low, high",
    [
        ("glazed.k_d.r", 0, 1),
        ("object.ball.radius", 0.225, 3.6),
        ("light.lamp.colour.g", 0, 9),
        ("light.sun.direction.u", -90, 90),
        ("camera.main.vfov_deg", 23, 113),
        ("texture.tiles.size", 0.325, 5.2),
        ("scene.ambient.b", 0, 10),
    ],
)
def test_bounds_that_nobody_gave(name, low, high):
    (unknown,) = list_unknowns(one_of_each(), [name])
    assert unknown.bounds == pytest.approx((low, high))


def test_places_are_looked_for_within_the_size_of_the_scene():
    """From the camera at z = 5.5 to the sphere around the board, of radius |(0.7, 1, 0.2)| about z = -1.8."""
    size = 5.5 + 1.8 + np.sqrt(0.7**2 + 1 + 0.2**2)
    unknowns = list_unknowns(one_of_each(), ["light.lamp.position"], {"light.lamp.position.y": (1, 4)})
    assert [u.bounds for u in unknowns] == [
        pytest.approx((2 - size, 2 + size)), (1, 4), pytest.approx((3 - size, 3 + size))
    ]  # fmt: skip
    with pytest.raises(FitError, match="bounds: object.ball.radius = 0 to 1; allowed is low < high with low > 0"):
        list_unknowns(one_of_each(), ["object.ball.radius"], {"object.ball.radius": (0, 1)})


class Strip(AbstractLight):
    """A light that the package does not have: so much along a direction, fading with a length."""

    TYPE = "strip"
    ROWS = (
        Row("facing", "direction", "Towards the light.", nonzero=True, moves="shadows"),
        Row("width", "number", "Metres.", unit="m", lowest=0, excluded=True, scale="log"),
        Row("tint", "colour", "Linear RGB.", lowest=0, fit_bounds=(0.0, 2.0)),
    )
    facing: Array
    width: Array
    tint: Array
    name: str | None = eqx.field(static=True)

    def __init__(self, facing, width, tint, name=None, place="strip"):
        self.name = name
        read_rows(self, place, facing=facing, width=width, tint=tint)

    def arriving(self, point):
        far = jnp.full_like(point.x, jnp.inf)
        return normalise(vec3(self.facing)) * jnp.ones_like(point.x), far, vec3(self.tint) * self.width


def test_a_kind_that_is_registered_has_its_names_from_its_rows():
    with LIGHTS.including(Strip):
        scene = dw.Scene(
            objects=[dw.Sphere("ball", (0, 0, 0), 1, "red")],
            materials={"red": dw.Material(k_d=(0.7, 0.4, 0.2))},
            lights=[Strip((0, 1, 1), 0.5, (1, 1, 1), name="neon")],
            cameras={"main": dw.Camera((0, 0.5, 5), (0, 0, 0), 40, 12, 8)},
        )
        assert [p.name for p in dw.parameters(scene) if p.family == "light"] == [
            "light.neon.facing", "light.neon.width", "light.neon.tint"
        ]  # fmt: skip
        wider = dw.replace_parameter(scene, "light.neon.width", 1.0)
        pictures = [np.asarray(dw.render(s, s.cameras["main"])) for s in (scene, wider)]
        np.testing.assert_allclose(pictures[1], 2 * pictures[0], rtol=1e-6)
        unknowns = list_unknowns(scene, ["light.neon.facing", "light.neon.width", "light.neon.tint.g"])
        assert [(u.name, u.bounds) for u in unknowns] == [
            ("light.neon.facing.u", (-90, 90)), ("light.neon.facing.v", (-90, 90)),
            ("light.neon.width", (0.125, 2)), ("light.neon.tint.g", (0, 2)),
        ]  # fmt: skip
        with pytest.raises(dw.SceneError, match="light 'neon': width = 0; allowed is > 0"):
            dw.replace_parameter(scene, "light.neon.width", 0)


def test_an_empty_name_is_a_name_and_two_lights_without_one_are_two():
    ball, lamp = dw.Sphere("", (0, 0, 0), 1, ""), dw.PointLight((1, 2, 3), 1.0, name="")
    camera, tiles = dw.Camera((0, 0, 5), (0, 0, 0), 40, 8, 6), dw.Checker([(1, 1, 1), (0, 0, 0)])
    scene = dw.Scene(
        objects=[ball], materials={"": dw.Material()}, lights=[lamp, lamp], cameras={"": camera}, textures={"": tiles}
    )
    assert [light.name for light in scene.lights] == ["light_1", "light_2"]
    for parameter in dw.parameters(scene):
        assert dw.scene.find_parameter(scene, parameter.name) == (parameter, None)


@pytest.mark.parametrize("value", [5.0, 7, None, [[0, 0, 0], [1, 0]], 10**400])
def test_corners_that_are_no_list_of_points_are_refused(value):
    with pytest.raises(dw.SceneError, match="vertices"):
        dw.replace_parameter(one_of_each(), "object.sail.vertices", value)
    with pytest.raises(dw.SceneError, match="vertices"):
        dw.Polygon("sail", value, "matte")
