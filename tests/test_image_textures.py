"""Image textures: mappings and wraps against formulas written here, means over footprints, derivatives, orientation."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.numerics._vector import vec3
from diffwhitted.records import changed
from diffwhitted.scene import TexturePoint
from diffwhitted.scene.textures._levels import level_sizes, pyramid

RANDOM = np.random.default_rng(20)
TEXELS = RANDOM.random((5, 8, 3))
POINTS = RANDOM.normal(size=(300, 3)) * 2
NORMALS = (lambda n: n / np.linalg.norm(n, axis=1, keepdims=True))(RANDOM.normal(size=(300, 3)))
CENTRE = np.array([0.3, -0.2, 0.1])
KEYS = {
    "planar": dict(origin=(0.2, -0.4, 0.1), edge_u=(2, 0.3, 0), edge_v=(-0.4, 1.5, 0.7)),
    "spherical": dict(centre=CENTRE),
    "cylindrical": dict(centre=CENTRE, height=3.0),
    "triplanar": dict(size=1.7),
    "uv": {},
}


def oracle_texel(texels, row, column, wrap):
    """The texel of a row from the bottom up and a column, for whole numbers that may lie outside."""
    height, width = texels.shape[:2]

    def inside(k, n):
        if wrap == "repeat":
            return k % n
        if wrap == "clamp":
            return min(max(k, 0), n - 1)
        k %= 2 * n
        return k if k < n else 2 * n - 1 - k

    return texels[height - 1 - inside(row, height), inside(column, width)]


def oracle(texels, u, v, wrap):
    """Bilinear interpolation by the four texels around, one point at a time."""
    found = []
    height, width = texels.shape[:2]
    for x, y in zip(np.asarray(u) * width - 0.5, np.asarray(v) * height - 0.5, strict=True):
        column, row = int(np.floor(x)), int(np.floor(y))
        found.append(
            sum(
                (1 - abs(x - c)) * (1 - abs(y - r)) * oracle_texel(texels, r, c, wrap)
                for r in (row, row + 1)
                for c in (column, column + 1)
            )
        )
    return np.array(found)


def oracle_colour(mapping, texels, wrap):
    """The colours at POINTS by the conventions, with numpy's least squares and complex numbers."""
    if mapping == "uv":
        return oracle(texels, POINTS[:, 0], POINTS[:, 1], wrap)
    if mapping == "planar":
        edges = np.array([KEYS["planar"]["edge_u"], KEYS["planar"]["edge_v"]]).T
        u, v = np.linalg.lstsq(edges, (POINTS - KEYS["planar"]["origin"]).T, rcond=None)[0]
        return oracle(texels, u, v, wrap)
    if mapping == "triplanar":
        x, y, z = POINTS.T / KEYS["triplanar"]["size"]
        planes = (oracle(texels, *uv, wrap) for uv in ((-z, y), (x, -z), (x, y)))
        return sum(n[:, None] ** 2 * colour for n, colour in zip(NORMALS.T, planes, strict=True))
    away = POINTS - CENTRE
    # From -z (the real axis) towards +x (the imaginary one).
    u = np.angle(-away[:, 2] + 1j * away[:, 0]) / (2 * np.pi) % 1
    if mapping == "cylindrical":
        return oracle(texels, u, 0.5 + away[:, 1] / KEYS[mapping]["height"], wrap)
    polar = np.arccos(away[:, 1] / np.linalg.norm(away, axis=1))
    return oracle(texels, u, 1 - polar / np.pi, wrap)


def where(points, normals=NORMALS, uv=None) -> TexturePoint:
    return TexturePoint(vec3(jnp.asarray(points)), vec3(jnp.asarray(normals[: len(points)])), uv)


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
@pytest.mark.parametrize("mapping", list(KEYS))
def test_a_mapping_is_what_the_conventions_say(mapping, wrap):
    texture = dw.ImageTexture(TEXELS, mapping=mapping, wrap=wrap, **KEYS[mapping])
    uv = (jnp.asarray(POINTS[:, 0]), jnp.asarray(POINTS[:, 1])) if mapping == "uv" else None
    found = texture.at(where(POINTS, uv=uv)).stacked()
    np.testing.assert_allclose(found, oracle_colour(mapping, TEXELS, wrap), atol=1e-12)


@pytest.mark.parametrize(
    ("wrap", "left", "right"), [("repeat", (0, -1), (0, -1)), ("clamp", (0, 0), (-1, -1)), ("mirror", (0, 0), (-1, -1))]
)
def test_a_seam_joins_the_texels_that_the_wrap_says(wrap, left, right):
    """On the seams u = 0 and u = 1, at the height of the middle row, the mean of the two texels beside them."""
    texture = dw.ImageTexture(TEXELS, mapping="planar", wrap=wrap)
    seams = np.array([[0.0, 0.5, 0.0], [1.0, 0.5, 0.0]])
    expected = [TEXELS[2, list(pair)].mean(axis=0) for pair in (left, right)]
    np.testing.assert_allclose(texture.at(where(seams)).stacked(), expected, atol=1e-12)


def test_directions_and_rows():
    """-z is the left edge, +x a quarter to the right, the lowest row is at the bottom; the axis itself is finite."""
    column = np.repeat(np.arange(4.0)[None, :, None], 4, axis=0).repeat(3, axis=2)
    ball = dw.ImageTexture(column, mapping="spherical")
    middles = [(np.sin(a), 0, -np.cos(a)) for a in 2 * np.pi * (np.arange(4) + 0.5) / 4]
    np.testing.assert_allclose(ball.at(where(np.array(middles))).x, [0, 1, 2, 3], atol=1e-12)
    row = column.swapaxes(0, 1)
    wall = dw.ImageTexture(row, mapping="planar")
    np.testing.assert_allclose(wall.at(where(np.array([[0.5, 0.125, 0], [0.5, 0.875, 0]]))).x, [3, 0], atol=1e-12)
    odd = np.array([[0, 1.0, 0], [0, -1.0, 0], [0, 0, 0]])
    values, slopes = jax.jvp(lambda p: ball.at(where(p)).stacked(), (jnp.asarray(odd),), (jnp.ones((3, 3)),))
    assert np.isfinite(values).all() and np.isfinite(slopes).all()


@pytest.mark.parametrize("shape", [(1, 1), (4, 8), (5, 7), (1, 6), (9, 2)])
def test_every_level_has_the_mean_of_the_picture(shape):
    texels = RANDOM.random((*shape, 3))
    levels, first = pyramid(texels), 0
    traced = jax.jit(pyramid)(texels)
    np.testing.assert_allclose(traced, levels, atol=1e-12)
    for height, width in level_sizes(*shape):
        level = levels[first : first + height * width]
        np.testing.assert_allclose(level.mean(axis=0), texels.mean(axis=(0, 1)), atol=1e-12)
        first += height * width
    assert first == len(levels)


def wall(texture, footprint=0, tilt=0.0, size=(24, 18), precision="float32", at=(0.0, 0.0, 0.0)):
    """A wall that fills the picture and shows the texture as it is."""
    camera = dw.Camera(np.add(at, (0, 5 * np.sin(tilt), 5 * np.cos(tilt))), at, 20, *size)
    return dw.Scene(
        objects=[dw.Plane("wall", (0, 0, 1), at[2], "paint")],
        materials={"paint": dw.Material(k_d=0, k_h=0, k_a=1, k_a_texture="picture")},
        textures={"picture": texture},
        cameras={"main": camera},
        max_depth=1,
        footprint=footprint,
        precision=precision,
    )


def pixel_mean(scene, side=16):
    """The mean over the pixels, by side x side points in each: a picture of more pixels, box-averaged."""
    camera = scene.cameras["main"]
    fine = dw.Camera(camera.look_from, camera.look_at, camera.vfov_deg, camera.width * side, camera.height * side)
    found = np.asarray(dw.render(scene, fine, footprint=0))
    return found.reshape(camera.height, side, camera.width, side, 3).mean(axis=(1, 3))


@pytest.mark.parametrize(("tilt", "texels_a_pixel"), [(0.0, 0.5), (0.0, 8.0), (1.2, 2.0), (1.2, 8.0)])
def test_a_footprint_sees_the_mean(tilt, texels_a_pixel):
    """White noise, the hardest texture; points alone are wrong by four times as much, and more."""
    pixel = 2 * 5 * np.tan(np.radians(10)) / 18
    size = 64 * pixel / texels_a_pixel
    noise = np.random.default_rng(3).random((64, 64, 3))
    turned = dict(edge_u=(0.8 * size, 0.6 * size, 0), edge_v=(-0.6 * size, 0.8 * size, 0))
    scene = wall(dw.ImageTexture(noise, mapping="planar", **turned), footprint=1, tilt=tilt)
    truth = pixel_mean(scene)
    filtered, points = (
        np.sqrt(((np.asarray(dw.render(scene, scene.cameras["main"], footprint=f)) - truth) ** 2).mean())
        for f in (1, 0)
    )
    assert filtered < 0.02 and points > 4 * filtered


def test_an_f_stands_upright():
    """Ink at the left and at the top, as in the array that was handed over."""
    letter = np.ones((8, 8, 3))
    letter[1:7, 2] = letter[1, 2:6] = letter[3, 2:5] = 0
    scene = wall(dw.ImageTexture(letter, mapping="planar", origin=(-0.8, -0.8, 0), edge_u=(1.6, 0, 0),
                                 edge_v=(0, 1.6, 0), wrap="clamp"))  # fmt: skip
    picture = np.asarray(dw.render(scene, scene.cameras["main"]))[..., 0]
    inked = np.argwhere(picture < 0.5)
    top, bottom = picture[: len(picture) // 2], picture[len(picture) // 2 :]
    left = picture[:, : picture.shape[1] // 2]
    assert (top < 0.5).sum() > 1.5 * (bottom < 0.5).sum() and (left < 0.5).sum() > 0.6 * len(inked)


def test_the_picture_is_differentiable_in_texels_and_mapping():
    """Reverse mode against central differences in float64."""
    texture = dw.ImageTexture(TEXELS, mapping="planar", origin=(-1, -1, 0), edge_u=(1.3, 0.2, 0), edge_v=(0, 1.1, 0))
    scene = wall(texture, tilt=0.6, size=(8, 6), precision="float64")
    plan = dw.plan(scene, scene.cameras["main"])
    weights = jnp.asarray(RANDOM.normal(size=(6, 8, 3)))

    def loss(values):
        new = scene
        for name, value in values.items():
            new = dw.replace_parameter(new, f"texture.picture.{name}", value)
        return (weights * dw.render(new, new.cameras["main"], plan=plan)).sum()

    start = {"texels": jnp.asarray(TEXELS), "origin": jnp.asarray([-1.0, -1, 0]), "edge_v": jnp.asarray([0, 1.1, 0])}
    agree_with_differences(loss, start)


def agree_with_differences(loss, start) -> None:
    """The gradient in each of the values, along a random direction; steps too short to meet another texel."""
    slopes = jax.jit(jax.grad(loss), compiler_options=SOON_COMPILED)(start)
    value = jax.jit(loss, compiler_options=SOON_COMPILED)
    for name, step in (("texels", 1e-4), ("origin", 1e-8), ("edge_v", 1e-8)):
        way = jnp.asarray(RANDOM.normal(size=start[name].shape))
        above, below = (value(start | {name: start[name] + sign * step * way}) for sign in (1, -1))
        difference = (above - below) / (2 * step)
        assert np.isfinite(slopes[name]).all() and abs(difference) > 1e-3
        np.testing.assert_allclose((slopes[name] * way).sum(), difference, rtol=2e-5)


@pytest.mark.parametrize("slant", [None, 0.4])
def test_means_are_differentiable(slant):
    """Over footprints of a third to nine texels, on both paths."""
    texture = dw.ImageTexture(TEXELS, mapping="planar", origin=(-1, -1, 0), edge_u=(1.3, 0.2, 0), edge_v=(0, 1.1, 0))
    point = where(POINTS[:40] * [1, 1, 0])
    still = vec3(jnp.zeros((40, 3)))
    sizes = jnp.asarray(RANDOM.uniform(0.05, 1.5, (40, 1)))
    steps = tuple(TexturePoint(vec3(sizes * jnp.asarray(way)), still) for way in ((0.9, 0.1, 0), (-0.2, 0.6, 0)))
    weights = vec3(jnp.asarray(RANDOM.normal(size=(40, 3))))

    def loss(values):
        table = changed(texture, **values).tabled()
        one = jax.tree.map(lambda a: jnp.asarray(a)[None], table).chosen(jnp.zeros(40, jnp.int32))
        mean = (
            one.mean(point, steps)
            if slant is None
            else one.mean_in_perspective(point, steps, (slant * sizes[:, 0],) * 2)
        )
        return (mean * weights).stacked().sum()

    agree_with_differences(loss, {name: jnp.asarray(getattr(texture, name)) for name in ("texels", "origin", "edge_v")})


@pytest.mark.parametrize("mapping", ["spherical", "cylindrical", "triplanar"])
def test_numbers_of_other_mappings_are_differentiable(mapping):
    """Colours at many points, along all numbers of the mapping at once."""
    start = {name: jnp.asarray(value, float) for name, value in KEYS[mapping].items()}
    ways = {name: jnp.asarray(RANDOM.normal(size=value.shape)) for name, value in start.items()}
    texture = dw.ImageTexture(TEXELS, mapping=mapping)

    def colours(step):
        return changed(texture, **{name: start[name] + step * ways[name] for name in start}).at(where(POINTS)).stacked()

    slopes = jax.jacfwd(colours)(0.0)
    assert abs(slopes).max() > 0.1
    np.testing.assert_allclose(slopes, (colours(1e-8) - colours(-1e-8)) / 2e-8, atol=1e-5 * abs(slopes).max())


@pytest.mark.parametrize("mapping", ["planar", "triplanar"])
def test_a_scene_far_away_looks_the_same(mapping):
    """At the coordinates of a map, where float32 resolves 3 cm."""
    away = np.array([4e5, 2e5, -3e5])
    here, there = (
        wall(dw.ImageTexture(TEXELS, mapping=mapping, **({"origin": by} if mapping == "planar" else {})).moved(
            np.zeros(3) if mapping == "planar" else by), at=by) for by in (np.zeros(3), away)
    )  # fmt: skip
    pictures = [np.asarray(dw.render(scene, scene.cameras["main"])) for scene in (here, there)]
    assert np.std(pictures[0]) > 0.05
    np.testing.assert_allclose(*pictures, atol=2e-4)


def test_pictures_of_several_sizes_and_wraps_in_one_scene():
    """Two of one structure are stacked, the third is not; each object has the texels of its own."""
    shades = {"a": (2, 2), "b": (2, 2), "c": (3, 1)}
    rects = {name: [(x, -0.4, 0), (x + 0.5, -0.4, 0), (x + 0.5, 0.4, 0), (x, 0.4, 0)]
             for name, x in zip(shades, (-0.9, -0.3, 0.3), strict=True)}  # fmt: skip
    scene = dw.Scene(
        objects=[dw.Polygon(name, corners, name) for name, corners in rects.items()],
        materials={name: dw.Material(k_d=0, k_h=0, k_a=1, k_a_texture=name) for name in shades},
        textures={
            name: dw.ImageTexture(np.full((*shape, 3), shade), mapping="triplanar")
            for (name, shape), shade in zip(shades.items(), (0.2, 0.5, 0.8), strict=True)
        },
        cameras={"main": dw.Camera((0, 0, 5), (0, 0, 0), 20, 24, 18)},
        max_depth=1,
    )
    row = np.asarray(dw.render(scene, scene.cameras["main"]))[9, :, 0]
    seen = row[row > 0]
    np.testing.assert_allclose(np.unique(np.round(seen, 6)), [0.2, 0.5, 0.8], atol=1e-6)
    assert (np.diff(seen) >= 0).all()
