"""Classes of materials, Fresnel's weights, absorption and the polished surface: against algebra and other programs."""

import functools
import json
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from colour.phenomena import polarised_light_reflection_coefficient
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.accuracy._materials import has_fresnel, with_materials
from diffwhitted.accuracy._tracer import Tracer
from diffwhitted.optics import fresnel_exact, fresnel_schlick, refraction_radicand
from diffwhitted.tree import make_plan

ROWS = json.loads((Path(__file__).parent / "oracles" / "fresnel.json").read_text())["rows"]
WIDTH, HEIGHT = 8, 6
MODELS = {"exact": fresnel_exact, "schlick": fresnel_schlick}
EXTINCTION = np.array([0.1, 0.5, 2.0])


def ball(material, *more, background=1.0, materials=(), depth=12, **settings):
    """A ball of radius 1 before an even background, seen straight on."""
    settings = {"background": dw.ConstantBackground((background,) * 3)} | settings
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "stuff"), *more],
        materials={"stuff": material, **dict(materials)},
        cameras={"main": dw.Camera((0, 0, 5), (0, 0, 0), 20, WIDTH + 1, HEIGHT + 1)},
        max_depth=depth,
        precision="float64",
        **settings,
    )


def middle(scene):
    """The pixel in the middle, straight on."""
    return np.asarray(dw.render(scene, scene.cameras["main"]))[HEIGHT // 2, WIDTH // 2]


# Fresnel's reflectance


def incidence():
    n1, n2, angle = (np.array([row[key] for row in ROWS], float) for key in ("n1", "n2", "angle_deg"))
    cosine, eta = jnp.cos(jnp.radians(angle)), jnp.asarray(n1 / n2)
    return cosine, eta, refraction_radicand(cosine, eta)


@pytest.mark.parametrize("model, key", [(fresnel_exact, "R"), (fresnel_schlick, "schlick")])
def test_reflectance_is_that_of_the_table(model, key):
    np.testing.assert_allclose(model(*incidence()), [row[key] for row in ROWS], atol=1e-6)


def test_reflectance_is_that_of_colour_science():
    for n1, n2, angle in ((1, 1.5, 0.3), (1, 2.4, 1.2), (1.5, 1, 0.6), (1.33, 1.7, 1.5)):
        found = fresnel_exact(*(jnp.asarray(x) for x in (np.cos(angle), n1 / n2, 1 - (n1 / n2 * np.sin(angle)) ** 2)))
        bent = np.arcsin(n1 / n2 * np.sin(angle))
        of_planes = polarised_light_reflection_coefficient(n1, n2, *np.degrees((angle, bent)))
        np.testing.assert_allclose(found, np.mean(np.real(of_planes)), atol=1e-12)


def test_nothing_is_reflected_in_one_plane_at_brewsters_angle():
    angle = np.arctan(1.5)
    cos_r = np.sqrt(1 - (np.sin(angle) / 1.5) ** 2)
    across = ((np.cos(angle) - 1.5 * cos_r) / (np.cos(angle) + 1.5 * cos_r)) ** 2
    found = fresnel_exact(jnp.asarray(np.cos(angle)), jnp.asarray(1 / 1.5), jnp.asarray(cos_r**2))
    np.testing.assert_allclose(found, across / 2, rtol=1e-13)


@pytest.mark.parametrize("model", [fresnel_exact, fresnel_schlick])
def test_reflectance_has_finite_derivatives_everywhere(model):
    def of(cosine, eta):
        return model(cosine, eta, refraction_radicand(cosine, eta))

    for eta in (0.5, 1.0, 1.5, 1 / 1.5, 100.0):
        for cosine in (0.0, 1e-9, np.sqrt(max(1 - 1 / eta**2, 0)), 0.5, 1.0):
            value, slopes = jax.value_and_grad(of, (0, 1))(jnp.asarray(cosine), jnp.asarray(eta))
            assert 0 <= value <= 1 and np.isfinite(slopes).all()
    assert (np.asarray(jax.grad(of, (0, 1))(jnp.asarray(0.1), jnp.asarray(1.5))) == 0).all()


# What rays carry


def floor_of(material, **settings):
    """A floor seen at many angles under an even sky, black below."""
    return dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0), 0, "floor")],
        materials={"floor": material},
        cameras={"main": dw.Camera((0, 1, 0), (0, 0.2, -2), 50, WIDTH, HEIGHT)},
        background=dw.GradientBackground((1, 1, 1), (1, 1, 1)),
        precision="float64",
        max_depth=2,
        **settings,
    )


def cosines(scene):
    camera = scene.cameras["main"]
    ray = camera.rays(*camera.place(jnp.arange(WIDTH * HEIGHT), jnp.asarray([0.5, 0.5])))
    return -np.asarray(ray.direction.y).reshape(HEIGHT, WIDTH, 1)


@pytest.mark.parametrize("model", ["exact", "schlick"])
def test_mirror_ray_carries_the_reflectance_times_k_s(model):
    scene = floor_of(dw.Material(k_s=(1, 0.5, 0.2), k_h=0, refractive_index=1.5, fresnel=model))
    cosine = cosines(scene)
    of = {"exact": fresnel_exact, "schlick": fresnel_schlick}[model]
    expected = np.asarray(of(cosine, 1 / 1.5, 1 - (1 - cosine**2) / 2.25)) * [1, 0.5, 0.2]
    below = cosine > 0
    found = np.asarray(dw.render(scene, scene.cameras["main"]))
    np.testing.assert_allclose(found, np.where(below, expected, 1), atol=1e-12)


def test_a_knob_chooses_between_the_models_of_the_angle():
    """What the scene says is left alone; metals and polished surfaces have one model only."""
    scene = floor_of(dw.Material(k_s=1, k_h=0, fresnel="exact", refractive_index=1.5))
    tracer = Tracer(scene, scene.cameras["main"])
    pictures = {model: tracer.trace(dw.Settings(fresnel=model)).pixels for model in (None, "exact", "schlick")}
    np.testing.assert_array_equal(pictures[None], pictures["exact"])
    cosine, index = cosines(scene), 1 / 1.5
    of = {m: f(cosine, index, refraction_radicand(cosine, index)) for m, f in MODELS.items()}
    difference = (pictures["schlick"] - pictures["exact"])[:, 0] / pictures["exact"][:, 0]
    np.testing.assert_allclose(difference, np.asarray(of["schlick"] / of["exact"]).ravel() - 1, atol=1e-9)
    coated = with_materials(floor_of(dw.Material(class_="polished", k_d=0.5)), "exact", None)
    assert coated.materials["floor"].fresnel == "schlick" and not has_fresnel(coated)
    with pytest.raises(dw.SceneError, match="fresnel = 'off'; allowed is exact, schlick"):
        dw.Settings(fresnel="off")


def test_metal_is_its_colour_straight_on_and_white_along_the_surface():
    gold = np.array([1.0, 0.78, 0.34])
    scene = floor_of(dw.Material(class_="metal", k_s=gold, k_h=0))
    cosine = cosines(scene)
    expected = gold + (1 - gold) * (1 - cosine) ** 5
    np.testing.assert_allclose(dw.render(scene, scene.cameras["main"]), np.where(cosine > 0, expected, 1), atol=1e-12)


def test_a_clear_ball_in_an_even_room_is_not_to_be_seen():
    """White furnace: all light that is not followed is in the bound."""
    scene = ball(dw.Material(class_="dielectric"), depth=6)
    found = dw.render_with_bound(scene, scene.cameras["main"])
    missing, bound = 1 - np.asarray(found.image), np.asarray(found.left_out)
    assert missing.max() > 1e-9
    assert (missing >= -1e-12).all() and (missing <= bound + 1e-12).all() and bound.max() < 0.5


@pytest.mark.parametrize("model", ["exact", "schlick"])
def test_total_reflection_continues_what_comes_before(model):
    """From within glass, on both sides of the critical angle, the light that leaves is that which comes."""
    scene = ball(dw.Material(class_="dielectric", k_s=0.6, k_t=0.8, fresnel=model), depth=2)
    scene = dw.Scene(
        objects=[dw.Plane("water", (0, 1, 0), 0, "stuff")],
        materials=scene.materials,
        cameras={"main": dw.Camera((0, -1, 0), (0, 0, -0.894427), 6, WIDTH, 24)},
        background=dw.ConstantBackground((1, 1, 1)),
        precision="float64",
        max_depth=2,
    )
    column = np.asarray(dw.render(scene, scene.cameras["main"]))[:, 4, 0]
    past = 0.6 + (1 - 0.6) * 0.8
    total = abs(column - past) < 1e-12
    assert total.sum() > 4 and (~total).sum() > 4 and (column <= past + 1e-12).all()
    assert abs(column[~total] - past).min() < 0.05


# What glass absorbs


def test_a_ball_straight_through_is_the_closed_series_of_its_reflections():
    scene = ball(dw.Material(class_="dielectric", extinction=EXTINCTION), depth=14)
    back, left = 0.04, np.exp(-2 * EXTINCTION)
    np.testing.assert_allclose(middle(scene), back + (1 - back) ** 2 * left / (1 - back * left), atol=1e-12)


def test_what_is_absorbed_in_glass_within_glass():
    """A ball of water of 0.5 in a ball of glass of 1: the way in each of them, by hand."""
    inner = dw.Sphere("drop", (0, 0, 0), 0.5, "water")
    water = dw.Material(k_t=1, k_h=0, refractive_index=1, extinction=2 * EXTINCTION)
    scene = ball(dw.Material(k_t=1, k_h=0, extinction=EXTINCTION), inner, materials={"water": water})
    np.testing.assert_allclose(middle(scene), np.exp(-EXTINCTION * 1.0 - 2 * EXTINCTION * 1.0), rtol=1e-12)


def test_a_dark_ball_in_absorbing_glass_is_seen_through_it():
    inner = dw.Sphere("stone", (0, 0, 0), 0.5, "stone")
    scene = ball(dw.Material(k_t=1, k_h=0, extinction=EXTINCTION), inner, materials={"stone": dw.Material(k_a=0.8)})
    np.testing.assert_allclose(middle(scene), 0.8 * np.exp(-EXTINCTION * 0.5), rtol=1e-12)
    within = dw.Camera((0, 0, 0.75), (0, 0, 0), 20, WIDTH + 1, HEIGHT + 1)
    seen = np.asarray(dw.render(scene, within))[HEIGHT // 2, WIDTH // 2]
    np.testing.assert_allclose(seen, 0.8 * np.exp(-EXTINCTION * 0.25), rtol=1e-12)


def test_nothing_comes_from_without_end_in_an_absorbing_medium():
    scene = floor_of(dw.Material(k_t=1, k_h=0, extinction=(0.0, 0.1, 3.0)))
    below = np.asarray(dw.render(scene, scene.cameras["main"]))[-1]
    np.testing.assert_array_equal(below, np.broadcast_to([1.0, 0.0, 0.0], below.shape))


SHADOWS = {
    "one ball": ([("ball", 1.0, 0.0, "glass")], lambda a, b: 2 * a),
    "two of one material": ([("ball", 0.5, 1.0, "glass"), ("other", 0.25, -1.0, "glass")], lambda a, b: 1.5 * a),
    "one in another": ([("ball", 1.0, 0.0, "glass"), ("drop", 0.5, 0.2, "water")], lambda a, b: a + b),
}


@pytest.mark.parametrize("lamp", [dw.DirectionalLight((0, 1, 0), (1, 1, 1)), dw.PointLight((0, 6, 0), (1, 1, 1))])
@pytest.mark.parametrize("case", SHADOWS)
def test_a_tinted_shadow_is_absorbed_by_the_length_inside(case, lamp):
    """The point of a floor straight under balls of glass, seen from the side: k_t for each surface, and Beer's law."""
    balls, metres = SHADOWS[case]
    water = 0.3 * EXTINCTION
    scene = dw.Scene(
        objects=[
            *(dw.Sphere(name, (0, height, 0), radius, material) for name, radius, height, material in balls),
            dw.Plane("floor", (0, 1, 0), -2, "floor"),
        ],
        materials={
            "glass": dw.Material(k_t=0.9, k_h=0, extinction=EXTINCTION),
            "water": dw.Material(k_t=0.8, k_h=0, extinction=water),
            "floor": dw.Material(k_d=1, k_h=0),
        },
        lights=[lamp],
        cameras={"main": dw.Camera((3, -1.5, 0), (0, -2, 0), 20, WIDTH + 1, HEIGHT + 1)},
        shadows="tinted",
        precision="float64",
    )
    surfaces = np.prod([{"glass": 0.9, "water": 0.8}[material] ** 2 for *_, material in balls])
    np.testing.assert_allclose(middle(scene), surfaces * np.exp(-metres(EXTINCTION, water)), rtol=1e-9)


def test_the_shadow_of_a_lamp_inside_glass_counts_the_way_to_its_surface():
    lamp = dw.PointLight((0, 0.5, 0), (1, 1, 1))
    scene = ball(
        dw.Material(k_t=1, k_h=0, extinction=EXTINCTION),
        dw.Plane("floor", (0, 1, 0), -2, "floor"),
        materials={"floor": dw.Material(k_d=1, k_h=0)},
        lights=[lamp],
        shadows="tinted",
        background=0.0,
    )
    camera = dw.Camera((3, -1.5, 0), (0, -2, 0), 20, WIDTH + 1, HEIGHT + 1)
    seen = np.asarray(dw.render(scene, camera))[HEIGHT // 2, WIDTH // 2]
    np.testing.assert_allclose(seen, np.exp(-EXTINCTION * 1.5), rtol=1e-9)


# Polished


def test_a_polished_floor_is_the_coupled_model():
    """Item by item: what ambient light, a lamp and the mirror ray bring (Shirley et al. 1997, Parker et al. 3.1)."""
    k_d, straight, towards = np.array([0.5, 0.3, 0.1]), 0.04, np.array([0.0, 0.6, 0.8])
    material = dw.Material(class_="polished", k_d=k_d, refractive_index=1.5)
    lamp = dw.DirectionalLight(towards, (0.9, 0.8, 0.7))
    scene = floor_of(material, lights=[lamp], ambient=(0.2, 0.3, 0.4))
    cosine = cosines(scene)
    through = (1 - (1 - cosine) ** 5) * k_d / (1 - straight)
    direct = 21 / 20 * through * (1 - (1 - 0.6) ** 5) * 0.6 * [0.9, 0.8, 0.7]
    mirrored = straight + (1 - straight) * (1 - cosine) ** 5
    expected = through * [0.2, 0.3, 0.4] + direct + mirrored
    found = np.asarray(dw.render(scene, scene.cameras["main"]))
    np.testing.assert_allclose(found, np.where(cosine > 0, expected, 1), atol=1e-12)


def test_a_polished_surface_sends_back_no_more_than_it_gets():
    limit = (1 - 0.04) ** 2
    scene = floor_of(dw.Material(class_="polished", k_d=limit, refractive_index=1.5))
    assert np.asarray(dw.render(scene, scene.cameras["main"])).max() <= 1 + 1e-12
    with pytest.raises(dw.SceneError, match=r"k_d = 0.93 .* at most \(1 - R0\)\^2 = 0.9216 .* refractive_index = 1.5"):
        dw.Material(class_="polished", k_d=0.93, refractive_index=1.5)


def test_what_comes_back_is_the_same_with_light_and_eye_exchanged():
    def sent_back(light_cosine, eye_cosine):
        towards = np.array([0.0, light_cosine, np.sqrt(1 - light_cosine**2)])
        scene = floor_of(
            dw.Material(class_="polished", k_d=0.5), lights=[dw.DirectionalLight(towards, (1, 1, 1))], ambient=(0, 0, 0)
        )
        eye = np.array([0.0, eye_cosine, np.sqrt(1 - eye_cosine**2)])
        camera = dw.Camera(eye * 5, (0, 0, 0), 1, WIDTH + 1, HEIGHT + 1)
        dark = dw.replace_parameter(scene, "background.top", np.zeros(3))
        dark = dw.replace_parameter(dark, "background.bottom", np.zeros(3))
        return np.asarray(dw.render(dark, camera))[HEIGHT // 2, WIDTH // 2, 0] / light_cosine

    np.testing.assert_allclose(sent_back(0.3, 0.9), sent_back(0.9, 0.3), rtol=1e-12)


def test_the_integral_that_couples_base_and_coat():
    nodes, weights = np.polynomial.legendre.leggauss(8)
    cosine = 0.5 * (nodes + 1)
    np.testing.assert_allclose(0.5 * weights @ ((1 - (1 - cosine) ** 5) * cosine), 10 / 21, rtol=1e-14)


@pytest.mark.parametrize("highlight, cosine", [("reflected", 0.6), ("halfway", np.cos(np.arccos(0.6)))])
def test_a_highlight_may_be_weighed_by_the_angle(highlight, cosine):
    """Light and eye at the same angle to either side: N.L = 0.6 is also L.H, and the lobe is 1."""
    scene = dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0), 0, "floor")],
        materials={
            "floor": dw.Material(
                k_h=(0.5, 0.25, 1), refractive_index=1.5, fresnel="exact", fresnel_highlight=True, highlight=highlight
            )
        },
        lights=[dw.DirectionalLight((0, 0.6, -0.8), (1, 1, 1))],
        cameras={"main": dw.Camera((0, 3, 4), (0, 0, 0), 1, WIDTH + 1, HEIGHT + 1)},
        precision="float64",
    )
    expected = fresnel_exact(jnp.asarray(cosine), jnp.asarray(1 / 1.5), jnp.asarray(1 - 0.64 / 2.25))
    np.testing.assert_allclose(middle(scene), expected * np.array([0.5, 0.25, 1]), rtol=1e-9)


# Classes


@pytest.mark.parametrize(
    "class_, refused, value",
    [
        ("diffuse", "k_s", 0.1),
        ("diffuse", "phong_exponent", 10),
        ("metal", "k_d", 0.1),
        ("metal", "k_t", 0.0),
        ("dielectric", "k_d", 0.2),
        ("polished", "k_a", 0.1),
        ("polished", "k_d_texture", None),
    ],
)
def test_a_class_refuses_what_it_does_not_have(class_, refused, value):
    if refused == "k_d_texture":
        assert dw.Material(class_=class_, k_d=0.1, k_d_texture="tiles").texture_at_work("k_a") == "tiles"
        return
    with pytest.raises(dw.SceneError, match=f"'p': {refused} is stated, .* class '{class_}' .* allowed is k_"):
        dw.Material(class_=class_, place="material 'p'", **{refused: value})


def test_a_class_and_a_model_that_do_not_exist_are_named():
    with pytest.raises(dw.SceneError, match=r"class = 'metall'; allowed is .* Did you mean 'metal'"):
        dw.Material(class_="metall")
    with pytest.raises(
        dw.SceneError, match=r"fresnel = 'exact' of a material of class 'metal'; allowed is \"schlick\""
    ):
        dw.Material(class_="metal", k_s=0.9, fresnel="exact")
    with pytest.raises(dw.SceneError, match=r"fresnel_highlight = true, and fresnel = \"off\""):
        dw.Material(k_h=0.3, fresnel_highlight=True)


TABLE = """
[[material]]
name = "lens"
class = "dielectric"
refractive_index = 1.7
extinction = [0.1, 0.2, 0.3]
[[material]]
name = "gold"
class = "metal"
k_s = [1, 0.8, 0.3]
fresnel_highlight = true
[[material]]
name = "table"
class = "polished"
k_d = 0.4
[[material]]
name = "wall"
class = "diffuse"
k_a = 0.1
k_d = [0.3, 0.3, 0.2]
[[material]]
name = "old"
k_s = 0.3
fresnel = "schlick"
"""


def test_a_file_says_what_the_class_does_not(tmp_path):
    scene = dw.parse_scene("[scene]\nmax_depth = 3\n" + TABLE)
    lens, gold, coat = (scene.materials[name] for name in ("lens", "gold", "table"))
    assert (float(lens.k_s), float(lens.k_t), lens.fresnel) == (1, 1, "exact")
    assert gold.fresnel == "schlick" and gold.at_work("k_h") is gold.k_s
    assert float(coat.refractive_index) == 1.5 and float(coat.k_h) == 0
    dw.save_scene(scene, tmp_path / "again.toml")
    text = (tmp_path / "again.toml").read_text()
    assert text.count("class =") == 4 and "k_a = 0.1" in text and text.count("k_t") == 1 + 1
    again = dw.load_scene(tmp_path / "again.toml")
    assert jax.tree.all(jax.tree.map(lambda a, b: bool((a == b).all()), scene, again))
    assert jax.tree.structure(scene) == jax.tree.structure(again)


def test_a_coefficient_that_a_class_does_not_have_is_no_parameter():
    scene = dw.parse_scene("[scene]\nmax_depth = 3\n" + TABLE)
    names = {parameter.name for parameter in dw.parameters(scene)}
    assert {"gold.k_s", "gold.phong_exponent", "lens.extinction"} <= names
    assert not {"gold.k_d", "lens.k_d", "wall.k_s", "table.k_a"} & names
    with pytest.raises(dw.SceneError, match=r"'gold.k_d': material 'gold' is of class 'metal', which has no k_d"):
        dw.parameter_value(scene, "gold.k_d")


# Derivatives


@functools.cache
def of_all_kinds():
    """Glass, metal, a coat and an old-fashioned surface, each with its angle, in each other's mirrors."""
    scene = dw.Scene(
        objects=[
            dw.Sphere("lens", (-0.7, 0, 0.6), 0.6, "lens"),
            dw.Sphere("ball", (0.8, 0, 0), 0.7, "gold"),
            dw.Plane("floor", (0, 1, 0), -0.7, "table"),
            dw.Plane("back", (0, 0, 1), -2, "old"),
        ],
        materials={
            "lens": dw.Material(class_="dielectric", k_s=0.9, k_h=0.3, extinction=(0.2, 0.3, 0.4)),
            "gold": dw.Material(class_="metal", k_s=(1, 0.8, 0.3), fresnel_highlight=True, phong_exponent=20),
            "table": dw.Material(class_="polished", k_d=(0.5, 0.3, 0.2), k_h=0.2, fresnel_highlight=True),
            "old": dw.Material(k_d=0.4, k_s=0.5, refractive_index=1.8, fresnel="schlick", phong_exponent=9),
        },
        lights=[dw.PointLight((2, 4, 5), (1, 0.9, 0.8))],
        cameras={"main": dw.Camera((0, 0.4, 5), (0, 0, 0), 35, WIDTH, HEIGHT)},
        background=dw.ConstantBackground((0.3, 0.4, 0.5)),
        shadows="tinted",
        max_depth=4,
        precision="float64",
    )
    names = tuple(p.name for p in dw.parameters(scene) if p.family == "material")
    values = {name: dw.parameter_value(scene, name) for name in names}
    plan = make_plan(scene, scene.cameras["main"], free=names)

    def image(values):
        new = scene
        for name, value in values.items():
            new = dw.replace_parameter(new, name, value)
        return dw.render(new, scene.cameras["main"], plan=plan)

    still = jax.tree.map(jnp.zeros_like, values)
    forward = jax.jit(lambda v, t: jax.jvp(image, (v,), (t,)), compiler_options=SOON_COMPILED)
    reverse = jax.jit(lambda v, w: jax.vjp(image, v)[1](w)[0], compiler_options=SOON_COMPILED)
    weights = np.random.default_rng(3).normal(size=(HEIGHT, WIDTH, 3))
    return values, still, forward, reverse(values, weights), weights


@pytest.mark.parametrize(
    "name",
    [
        *("lens.k_s", "lens.k_t", "lens.extinction", "lens.refractive_index", "lens.k_h", "gold.k_s"),
        *("gold.phong_exponent", "table.k_d", "table.refractive_index", "table.k_h", "old.k_s", "old.refractive_index"),
    ],
)
def test_derivative_is_the_central_difference(name):
    values, still, forward, reverse, weights = of_all_kinds()
    tangent = jnp.ones_like(values[name])
    slope = np.asarray(forward(values, still | {name: tangent})[1])
    step = 1e-6

    def moved(by):
        return np.asarray(forward(values | {name: values[name] + by * step * tangent}, still)[0])

    difference, wider = (moved(1) - moved(-1)) / (2 * step), (moved(2) - moved(-2)) / (4 * step)
    smooth = abs(difference - wider).max(axis=-1) < 1e-5 * abs(slope).max()
    assert np.isfinite(slope).all() and np.isfinite(reverse[name]).all() and abs(slope).max() > 1e-3
    assert smooth.mean() > 0.9
    np.testing.assert_allclose(slope[smooth], difference[smooth], atol=1e-6 * abs(slope).max())
    np.testing.assert_allclose((reverse[name] * tangent).sum(), (weights * slope).sum(), rtol=1e-9, atol=1e-12)
