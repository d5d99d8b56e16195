"""Bent normals: against closed forms, in their derivatives, what is softened far away, what cannot be, a fit."""

import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
import fitting
from diffwhitted._errors import SceneNote
from diffwhitted.formats._kinds import FORMATS
from diffwhitted.numerics._vector import vec3
from diffwhitted.scene import TexturePoint

WIDTH, HEIGHT = 12, 9
RANDOM = np.random.default_rng(25)
PATTERNS = {
    "noise": dw.Noise(size=0.7, octaves=2),
    "flat noise": dw.Noise(size=0.7, octaves=1, axes="xz"),
    "waves": dw.Waves(crests=[(0.5, 0.1, 0), (0.2, 0, 0.6)]),
    "dimples": dw.Dimples(size=0.6, share=0.9),
    "lanes": dw.Dimples(size=0.6, share=0.5, axes="y"),
}
SUN = np.array([0.3, 0.8, 0.52])
SUN = SUN / np.linalg.norm(SUN)
CREST, TALL = np.array([1.5, 0, 0.8]), 0.06
"""One wave on the floor, and its height."""


FLOOR = dw.Plane("floor", (0, 1, 0), 0, "floor")


def floor(texture=None, key="height_texture", background=None, objects=(FLOOR,), size=(WIDTH, HEIGHT), **material):
    """A floor under the sun, seen from near by."""
    material = {"k_d": 0.7, "k_h": 0} | material
    texture = dw.Waves(crests=[CREST]) if texture is None else texture
    material = {key: "relief"} | ({"height_scale": TALL} if key == "height_texture" else {}) | material
    return dw.Scene(
        objects=objects,
        materials={"floor": dw.Material(**material)},
        textures={"relief": texture},
        lights=[dw.DirectionalLight(SUN, 1)],
        cameras={"main": dw.Camera((0, 2, 1.5), (0, 0, 0), 30, *size)},
        background=background,
        precision="float64",
        max_depth=2,
    )


def picture(scene, **how):
    return np.asarray(dw.render(scene, scene.cameras["main"], **how))


def on_floor(scene):
    """Where the rays meet the floor, (n, 3), and their directions."""
    camera = scene.cameras["main"]
    ray = camera.rays(*camera.place(jnp.arange(camera.width * camera.height), jnp.asarray([0.5, 0.5])))
    origin, direction = (np.asarray(v.stacked()) for v in (ray.origin, ray.direction))
    return origin - direction * (origin[:, 1:2] / direction[:, 1:2]), direction


def wave_normals(points, tall=TALL, softened=1.0):
    """(-grad h, 1) of h = tall (1/2 + 1/2 sin(2 pi P.c / c**2)), written out."""
    along = 2 * np.pi * CREST / (CREST @ CREST)
    slope = 0.5 * tall * np.cos(points @ along)[:, None] * along * softened
    normal = np.array([0, 1, 0]) - slope
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def softening(scene, points):
    """What is left of the wave over the width of a pixel on the floor: exp(-(pi w / length)**2 / 6)."""
    camera = scene.cameras["main"]
    eye = np.asarray(camera.look_from)
    away = np.linalg.norm(points - eye, axis=1)
    width = away * 2 * np.tan(np.radians(15)) / camera.height / (eye[1] / away)
    return np.exp(-((np.pi * width) ** 2) / (CREST @ CREST) / 6)[:, None]


# What is bent


@pytest.mark.parametrize("name", PATTERNS)
def test_slopes_of_a_pattern_are_its_differences(name):
    pattern, step = PATTERNS[name], 1e-6
    points, ways = RANDOM.normal(size=(200, 3)) * 2, RANDOM.normal(size=(200, 3))

    def at(places):
        return TexturePoint(vec3(jnp.asarray(places)), vec3(jnp.zeros((200, 3))))

    colours = pattern.at(at(points)).stacked()
    assert (colours >= 0).all() and (colours <= 1).all() and np.ptp(colours) > 0.4
    (found,) = pattern.slopes(at(points), jnp.zeros(200), (at(ways),))
    difference = (pattern.at(at(points + step * ways)).x - pattern.at(at(points - step * ways)).x) / (2 * step)
    np.testing.assert_allclose(found, difference, atol=2e-5)


@pytest.mark.parametrize("name", PATTERNS)
def test_a_pattern_that_is_moved_is_the_same_there(name):
    points, by = RANDOM.normal(size=(50, 3)) * 2, np.array([1e3, -20.5, 333.25])

    def at(pattern, places):
        return pattern.at(TexturePoint(vec3(jnp.asarray(places)), vec3(jnp.zeros((50, 3))))).stacked()

    np.testing.assert_allclose(at(PATTERNS[name].moved(by), points + by), at(PATTERNS[name], points), atol=1e-9)


def test_a_wave_is_lit_by_its_normals():
    scene = floor()
    points, _ = on_floor(scene)
    expected = 0.7 * wave_normals(points, softened=softening(scene, points)) @ SUN
    np.testing.assert_allclose(picture(scene)[..., 0].ravel(), expected, rtol=1e-9)
    assert np.ptp(expected) > 0.02


def test_a_wave_mirrors_and_lets_through_by_its_normals():
    sky = dw.GradientBackground((0, 0, 0), (1, 1, 1))
    scene = floor(background=sky, k_d=0, k_s=1)
    points, direction = on_floor(scene)
    normal = wave_normals(points, softened=softening(scene, points))
    up = direction[:, 1] - 2 * (direction * normal).sum(axis=1) * normal[:, 1]
    np.testing.assert_allclose(picture(scene)[..., 0].ravel(), 0.5 * (1 + up), rtol=1e-9)
    glass = floor(background=sky, k_d=0, k_t=1, refractive_index=1.5)
    cosine, eta = -(direction * normal).sum(axis=1), 1 / 1.5
    down = eta * direction[:, 1] - (np.sqrt(1 - eta**2 * (1 - cosine**2)) - eta * cosine) * normal[:, 1]
    np.testing.assert_allclose(picture(glass)[..., 0].ravel(), 0.5 * (1 + down), rtol=1e-9)


LEAN = np.array([0.3, -0.2, 0.93])
LEAN = LEAN / np.linalg.norm(LEAN)
MESH = dw.Mesh(
    "sheet", [[-3, 0.5, 3], [3, 0.5, 3], [3, 0.5, -3], [-3, 0.5, -3]], [[0, 1, 2], [0, 2, 3]], "floor",
    uvs=[[0, 0], [1, 0], [1, 1], [0, 1]],
)  # fmt: skip


@pytest.mark.parametrize("mapping", ["planar", "triplanar", "uv", "cylindrical"])
def test_a_map_of_one_normal_leans_all_of_them(mapping):
    keys = {
        "planar": dict(edge_u=(2, 0, 0), edge_v=(0.5, 0, -3)),
        "triplanar": dict(size=2.0),
        "cylindrical": dict(centre=(0.0, 0.0, 5.0)),
    }.get(mapping, {})
    texture = dw.ImageTexture(np.full((4, 4, 3), 0.5 * (1 + LEAN)), mapping=mapping, **keys)
    shown = picture(floor(texture, "normal_texture", objects=[MESH if mapping == "uv" else FLOOR]))[..., 0].ravel()
    if mapping == "cylindrical":  # v does not change on the floor, so no frame is known
        np.testing.assert_allclose(shown, 0.7 * SUN[1], rtol=1e-12)
        return
    # Along +u (+x), +v (-z; of the slanted one what is at right angles to +u) and upwards.
    np.testing.assert_allclose(shown, 0.7 * np.array([LEAN[0], LEAN[2], -LEAN[1]]) @ SUN, rtol=1e-9)


def test_a_picture_of_heights_has_the_slopes_of_what_it_shows():
    """A ball with the heights 1/2 + 1/2 sin(4 longitude) cos(latitude)**2 in a picture, and as a function."""
    rows, columns = 128, 256
    latitude = np.pi * (0.5 - (np.arange(rows) + 0.5) / rows)[:, None]
    longitude = 2 * np.pi * (np.arange(columns) + 0.5)[None] / columns
    heights = 0.5 + 0.5 * np.sin(4 * longitude) * np.cos(latitude) ** 2
    texture = dw.ImageTexture(np.repeat(heights[..., None], 3, axis=2), mapping="spherical", centre=(0, 0, 0))
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "stone")],
        materials={"stone": dw.Material(k_d=1, k_h=0, height_texture="relief", height_scale=0.1)},
        textures={"relief": texture},
        lights=[dw.DirectionalLight((0, 0, 1), 1)],
        cameras={"main": dw.Camera((0, 0.3, 6), (0, 0, 0), 10, 40, 30)},
        precision="float64",
    )
    camera = scene.cameras["main"]
    ray = camera.rays(*camera.place(jnp.arange(1200), jnp.asarray([0.5, 0.5])))
    origin, direction = (np.asarray(v.stacked()) for v in (ray.origin, ray.direction))
    along = (origin * direction).sum(axis=1)
    point = origin - direction * (along + np.sqrt(along**2 - (origin**2).sum(axis=1) + 1))[:, None]

    def height(p):
        x, y, z = p.T
        beside = np.hypot(x, z)
        return 0.1 * (0.5 + 0.5 * np.sin(4 * np.arctan2(x, -z)) * (beside / np.linalg.norm(p, axis=1)) ** 2)

    slope = np.stack([(height(point + d) - height(point - d)) / 2e-6 for d in 1e-6 * np.eye(3)], axis=1)
    normal = point - (slope - (slope * point).sum(axis=1, keepdims=True) * point)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    np.testing.assert_allclose(picture(scene)[..., 0].ravel(), normal[:, 2], atol=3e-3)


# What is not let through


def test_no_light_comes_from_behind_the_surface():
    steep = dict(height_scale=3.0)
    below = {"cameras": {"main": dw.Camera((0, 2, 1.5), (0, 0, 0), 30, WIDTH, HEIGHT)}, "precision": "float64"}
    scene = floor(**steep)
    for shadows in ("off", "opaque"):
        dark = dw.Scene(
            objects=scene.objects, materials=dict(scene.materials), textures=dict(scene.textures),
            lights=[dw.DirectionalLight((1, -0.05, 0.5), 1)], shadows=shadows, **below,
        )  # fmt: skip
        assert (picture(dark) == 0).all()
    # What would be mirrored into the floor grazes it: the sky below is never seen.
    mirror = floor(background=dw.GradientBackground((100, 0, 0), (0, 1, 0)), k_d=0, k_s=1, **steep)
    assert picture(mirror)[..., 0].max() < 50.1 and (picture(mirror)[..., 1] > 0.49).all()


def test_a_low_lamp_fades_where_wrinkles_are_steeper():
    """3 t**2 - 2 t**3 of its height over the sine by which a normal leans."""
    lean = dw.ImageTexture(np.full((1, 1, 3), 0.5 * (1 + LEAN)), mapping="triplanar")
    scene, sine = floor(lean, "normal_texture"), np.sqrt(1 - LEAN[2] ** 2)
    normal = np.array([LEAN[0], LEAN[2], -LEAN[1]])
    for height in (0.05, 0.25, 0.5):
        sun = np.array([np.sqrt(1 - height**2), height, 0])
        low = dw.replace_parameter(scene, "light.light_1.direction", sun)
        t = min(height / sine, 1)
        np.testing.assert_allclose(picture(low)[..., 0], 0.7 * normal @ sun * t * t * (3 - 2 * t), rtol=1e-9)


# Far away


def test_far_away_the_floor_is_flat():
    far = floor(dw.Noise(size=0.01))
    np.testing.assert_allclose(picture(far)[..., 0], 0.7 * SUN[1], rtol=1e-3)
    texels = np.random.default_rng(1).random((64, 64, 1)) * np.ones(3)
    small = floor(dw.ImageTexture(texels, mapping="triplanar", size=0.02), height_scale=1e-3)
    np.testing.assert_allclose(picture(small)[..., 0], 0.7 * SUN[1], rtol=1e-3)


def test_a_footprint_is_taken_by_points():
    with pytest.warns(SceneNote, match=r"material 'floor' \(height_texture\) knows points only"):
        found = picture(floor(), footprint=1)
    assert abs(found - picture(floor())).mean() < 0.01


# Derivatives


def test_derivatives_of_heights_and_of_the_ball_that_wears_them():
    """A mirror that is wrinkled under a lamp that shines highlights, before a sky that changes with the height."""
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "steel")],
        materials={
            "steel": dw.Material(
                k_d=(0.2, 0.3, 0.4), k_h=0.4, k_s=0.5, phong_exponent=9, height_texture="relief", height_scale=0.03
            )
        },
        textures={"relief": dw.Waves(crests=[(0.7, 0.2, 0), (0, 0.4, 0.3)])},
        lights=[dw.PointLight((3, 3, 4), (1, 0.9, 0.8))],
        background=dw.GradientBackground((0.2, 0.2, 0.2), (1, 0.5, 0.1)),
        cameras={"main": dw.Camera((0.2, 0.3, 6), (0, 0, 0), 14, WIDTH, HEIGHT)},
        precision="float64",
        max_depth=2,
        shadows="off",
    )
    names = {
        "steel.height_scale": 0.03, "object.ball.radius": 1.0, "object.ball.centre.y": 0.0,
        "texture.relief.crests.0.x": 0.7,
    }  # fmt: skip
    plan = dw.plan(scene, scene.cameras["main"])

    def image(values):
        changed = scene
        for name, value in zip(names, values, strict=True):
            changed = dw.replace_parameter(changed, name, value)
        return dw.render(changed, changed.cameras["main"], plan=plan)

    weights = RANDOM.normal(size=(HEIGHT, WIDTH, 3))
    forward = jax.jit(lambda v, t: jax.jvp(image, (v,), (t,)), compiler_options=SOON_COMPILED)
    reverse = jax.jit(lambda v: jax.vjp(image, v)[1](weights)[0], compiler_options=SOON_COMPILED)
    values, step = np.array(list(names.values())), 1e-6
    back = np.asarray(reverse(values))
    for number, direction in enumerate(np.eye(len(names))):
        slope = np.asarray(forward(values, direction)[1])
        plus, minus = (np.asarray(forward(values + sign * step * direction, direction)[0]) for sign in (1, -1))
        assert np.isfinite(slope).all() and abs(slope).max() > 1e-2
        np.testing.assert_allclose(slope, (plus - minus) / (2 * step), atol=1e-6 * abs(slope).max())
        np.testing.assert_allclose(back[number], (weights * slope).sum(), rtol=1e-9)


def test_height_is_found():
    truth = picture(floor(k_h=0.3, phong_exponent=20))
    found = fitting.fit(
        floor(height_scale=0.02, k_h=0.3, phong_exponent=20), truth, free=("floor.height_scale", "floor.k_d")
    )
    by_name = {c.name: c.value for c in found.coefficients}
    assert abs(by_name["floor.height_scale"] - TALL) < 1e-6 and abs(by_name["floor.k_d"] - 0.7) < 1e-6


# What is wrong

IMAGE = dict(texels=np.full((2, 2, 3), 0.7), mapping="triplanar")
WRONG = {
    "no scale": (lambda: dw.Material(height_texture="a"), "height_texture is stated, and no height_scale"),
    "no texture": (lambda: dw.Material(height_scale=0.1), "height_scale is stated, and no height_texture"),
    "scaled normals": (
        lambda: dw.Material(height_scale=0.1, normal_texture="a"),
        "a normal_texture says how steep it is",
    ),
    "both": (
        lambda: dw.Material(height_scale=0.1, height_texture="a", normal_texture="a"),
        "height_texture and normal_texture are both stated",
    ),
    "below": (lambda: dw.Material(height_texture="a", height_scale=-1), "height_scale = -1; allowed is >= 0"),
    "steps": (lambda: floor(dw.Checker([(0, 0, 0), (1, 1, 1)])), "'checker', which has steps and no slopes"),
    "no picture": (lambda: floor(dw.Noise(), "normal_texture"), "is of type 'noise'; allowed is an image"),
    "no texture of that name": (lambda: floor(height_texture="relif"), "height_texture = 'relif' is not in the scene"),
    "no coordinates": (
        lambda: floor(dw.ImageTexture(np.full((2, 2, 3), 0.7))),
        "(plane) has no texture coordinates, which texture 'relief' (height_texture of material 'floor')",
    ),
    "codes": (lambda: floor(dw.ImageTexture(**IMAGE, file="bumps.png")), 'write encoding = "linear"'),
    "inwards": (
        lambda: floor(dw.ImageTexture(np.full((2, 2, 3), 0.4), mapping="triplanar"), "normal_texture"),
        "the texel in row 0, column 0 (from 0, top left) has blue = 0.4, a normal into the surface",
    ),
    "gouraud": (
        lambda: floor(objects=[dw.Mesh("tile", [[0, 1, 0], [1, 1, 0], [0, 1, 1]], [[0, 1, 2]], "floor",
                                       shading="gouraud")]),
        "object 'tile': shading = 'gouraud', by which lamps do not see",
    ),
    "no octave": (lambda: dw.Noise(octaves=0), "octaves = 0; allowed is a whole number from 1 to 8"),
    "no wave": (lambda: dw.Waves(crests=[(0, 0, 0)]), "any vectors but zero"),
    "no dent": (lambda: dw.Dimples(share=2), "share = 2; allowed is >= 0.01 and <= 1"),
}  # fmt: skip


@pytest.mark.parametrize("fault", WRONG)
def test_what_is_wrong_is_named(fault):
    make, said = WRONG[fault]
    with pytest.raises(dw.SceneError, match=re.escape(said)):
        make()


def test_a_file_keeps_what_bends_normals(tmp_path):
    for name, pattern in PATTERNS.items():
        scene = floor(pattern)
        dw.save_scene(scene, tmp_path / "scene.toml")
        again = dw.load_scene(tmp_path / "scene.toml", precision="float64")
        assert again.materials["floor"].relief == scene.materials["floor"].relief, name
        assert jax.tree.all(jax.tree.map(np.array_equal, again.textures, scene.textures)), name


def test_other_programs_are_told_what_they_do_not_get():
    glass = dw.Material(class_="dielectric", extinction=0.3, dispersion={"abbe": 40}, roughness=0.1, k_h=0,
                        height_texture="relief", height_scale=0.1)  # fmt: skip
    scene = floor()
    scene = dw.Scene(objects=[dw.Sphere("ball", (0, 1, 0), 1, "glass")], materials={"glass": glass},
                     textures=dict(scene.textures), cameras=dict(scene.cameras))  # fmt: skip
    words = "class", "fresnel", "extinction", "abbe_number", "roughness", "height_scale", 'height_texture "relief"'
    told = {
        form.name: " | ".join(form.write(scene, "x.toml").lost)
        for form in FORMATS
        if form.write and form.name != "TOML"
    }
    for name in ("POV-Ray", "Mitsuba", "glTF", "MTL"):
        for word in words:
            assert re.search(rf'{word} of material "glass" is lost', told[name]), (name, word, told[name])
    for name in ("LaTeX", "Markdown"):
        assert 'height_texture "relief" of material "glass" is lost' in told[name]
