"""Meshes: one object of many triangles, against polygons, against spheres and against their own definition."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mesh_samples import BOX, BOX_FACES, ball, bumpy

import diffwhitted as dw
from diffwhitted.shapes import Triangles

CAMERA = dw.Camera(look_from=(0.4, 0.9, 4), look_at=(0, 0, 0), up=(0, 1, 0), vfov_deg=40, width=24, height=18)
LAMPS = [dw.PointLight((3, 4, 3), (0.6, 0.6, 0.6)), dw.DirectionalLight((-1, 1, 0.3), (0.4, 0.4, 0.4))]
MATERIALS = {
    "glass": dw.Material(k_d=0, k_h=0.3, phong_exponent=20, k_s=0.1, k_t=(0.8, 0.9, 0.7), refractive_index=1.4),
    "clay": dw.Material(k_a=0.1, k_d=(0.7, 0.5, 0.4), k_h=0.2, phong_exponent=10),
    "mirror": dw.Material(k_d=0.2, k_s=0.6),
    "floor": dw.Material(k_a=0.1, k_d=0.8, k_d_texture="tiles"),
    "air": dw.Material(k_d=0, k_h=0, k_t=1, refractive_index=1),
}
SKY = dw.GradientBackground((0.2, 0.2, 0.3), (0.5, 0.7, 0.9))


def scene(*objects, camera=CAMERA, **settings) -> dw.Scene:
    return dw.Scene(
        objects=[*objects, dw.Plane("floor", (0, 1, 0), -1.2, "floor")],
        materials=MATERIALS,
        textures={"tiles": dw.Checker(((0.9, 0.9, 0.8), (0.2, 0.3, 0.5)), 0.7)},
        lights=LAMPS,
        cameras={"main": camera},
        background=SKY,
        **{"max_depth": 6, "shadows": "tinted"} | settings,
    )


def picture(*objects, camera=CAMERA, **settings) -> np.ndarray:
    return np.asarray(dw.render(scene(*objects, camera=camera, **settings), camera))


def cube(name="cube", material="glass", vertices=0.6 * BOX, faces=BOX_FACES, **more) -> dw.Mesh:
    return dw.Mesh(name, vertices, faces, material, **more)


# What a mesh is.


def test_a_glass_cube_is_its_six_polygons():
    polygons = [dw.Polygon(f"side {k}", 0.6 * BOX[np.asarray(face)], "glass") for k, face in enumerate(BOX_FACES)]
    one, other = picture(cube()), picture(*polygons)
    assert (abs(one - other).max(axis=-1) > 1e-5).mean() <= 0.01 and one.std() > 0.1


def test_glass_of_index_1_is_not_there():
    """Every ray goes straight through, whatever the normals that are interpolated."""
    vertices, faces = bumpy(2)
    with_it = picture(dw.Mesh("air", vertices, faces, "air", shading="flat"), max_depth=12)
    np.testing.assert_allclose(with_it, picture(max_depth=12), atol=2e-6)


@pytest.mark.parametrize("material", ["clay", "mirror"])
def test_a_smooth_mesh_looks_like_its_sphere(material):
    """20 480 triangles: the facets of the outline are below a pixel."""
    vertices, faces = ball(5)
    mesh, sphere = (
        dw.Mesh("ball", vertices, faces, material, shading="phong"),
        dw.Sphere("ball", (0, 0, 0), 1, material),
    )
    off = abs(picture(mesh) - picture(sphere)).max(axis=-1)
    assert np.sort(off.ravel())[-8:].max() < 0.5 and np.mean(off > 0.02) < 0.03 and np.median(off) < 1e-3


def test_no_triangle_stands_in_its_own_light():
    """Shading falls off to the terminator as on a sphere, without dark facets, on a coarse mesh too (Hanika 2021)."""
    vertices, faces = ball(2)
    lamp = dw.DirectionalLight((1, 0.2, 0.1), (1, 1, 1))
    camera = dw.Camera(look_from=(0, 0, 4), look_at=(0, 0, 0), up=(0, 1, 0), vfov_deg=25, width=24, height=18)
    clay = {"clay": dw.Material(k_d=1.0, k_h=0)}

    def lit(thing):
        return np.asarray(dw.render(dw.Scene(objects=[thing], materials=clay, lights=[lamp]), camera))

    mesh = lit(dw.Mesh("ball", vertices, faces, "clay", shading="phong"))
    sphere = lit(dw.Sphere("ball", (0, 0, 0), 1, "clay"))
    inside = (sphere > 0.02).all(axis=-1) & (mesh > 0).all(axis=-1)
    assert (sphere[..., 0] > 0.05).sum() - inside.sum() <= 6
    assert abs(mesh - sphere)[inside].max() < 0.15 and abs(mesh - sphere)[inside].mean() < 0.03


def test_the_inside_of_a_mesh_is_a_medium():
    """A ball of glass within a cube of the same glass is not there, and neither is one of clay behind a wall of it."""
    inner = dw.Sphere("inner", (0, 0, 0), 0.3, "glass")
    same = {"shadows": "off"}
    clear = dw.Material(k_d=0, k_h=0, k_t=1, refractive_index=1.4)
    one, other = (
        np.asarray(dw.render(changed_to(scene(*things, **same, max_depth=10), glass=clear), CAMERA))
        for things in ((cube(), inner), (cube(),))
    )
    assert (abs(one - other).max(axis=-1) > 1e-4).mean() < 0.02


def changed_to(scene_, **materials) -> dw.Scene:
    return dw.Scene(
        objects=scene_.objects, materials={**scene_.materials, **materials}, textures=scene_.textures,
        lights=scene_.lights, cameras=scene_.cameras, background=scene_.background, max_depth=scene_.max_depth,
        shadows=scene_.shadows,
    )  # fmt: skip


def test_points_inside():
    vertices, faces = bumpy(2)
    mesh = dw.Mesh("m", vertices, faces, "glass")
    assert mesh.closed and mesh.solid and not mesh.inside_out
    places = np.random.default_rng(0).uniform(-1.1, 1.1, (60, 3))
    far = np.linalg.norm(places, axis=1)
    for place, away in zip(places, far, strict=True):
        if away < 0.85 or away > 1.06:
            assert mesh.holds(place) == (away < 0.95)
    open_one = dw.Mesh("o", vertices, faces[1:], "glass")
    assert not open_one.closed and not open_one.holds((0, 0, 0))
    assert dw.Mesh("i", vertices, faces[:, ::-1], "glass").inside_out


def test_vertices_that_files_repeat_close_all_the_same():
    vertices, faces = ball(1)
    assert dw.Mesh("m", vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3), "glass").closed


# Normals.


def test_normals_of_vertices_are_the_means_of_their_faces():
    """Hearn and Baker (14-37), for the corner of a cube: (1, 1, 1) / sqrt(3) where three squares are cut alike."""
    mesh = cube(shading="phong")
    normals = np.asarray(mesh.corner_normals())
    vertices, faces = 0.6 * BOX, np.asarray(mesh.faces)
    flat = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    for vertex in range(8):
        expected = sum(flat[k] for k in range(len(faces)) if vertex in faces[k])
        found = normals[np.nonzero(faces == vertex)]
        np.testing.assert_allclose(found, np.tile(expected / np.linalg.norm(expected), (len(found), 1)), atol=1e-6)


def test_shares_of_a_point():
    corners = tuple(jnp.asarray(c, jnp.float32) for c in ((0.0, 0, 0), (2.0, 0, 1), (0.0, 3, 0)))
    from diffwhitted.numerics._vector import vec3

    one = Triangles(tuple(vec3(c[None]) for c in corners))
    point = vec3((0.2 * corners[0] + 0.5 * corners[1] + 0.3 * corners[2])[None])
    np.testing.assert_allclose([float(s[0]) for s in one.shares(point)], [0.2, 0.5, 0.3], atol=1e-6)


# Transforms.


def test_transforms_take_vertices_normals_and_balls_along():
    """Scale, then a turn about y, then a shift; normals stay square to the faces also where the scale is uneven."""
    vertices, faces = ball(1)
    there = dw.Mesh("m", vertices, faces, "clay", normals=vertices).placed(
        scale=(1, 2, 3), rotate_deg=(0, 90, 0), translate=(1, 2, 3)
    )
    found = there.as_placed()
    x, y, z = (vertices * [1, 2, 3]).T
    np.testing.assert_allclose(found.vertices, np.stack([z + 1, y + 2, 3 - x], axis=1), atol=1e-6)
    outwards = vertices / [1, 2, 3]
    outwards = np.stack([outwards[:, 2], outwards[:, 1], -outwards[:, 0]], axis=1)
    cosine = (outwards * found.normals).sum(axis=1)
    cosine /= np.linalg.norm(outwards, axis=1) * np.linalg.norm(found.normals, axis=1)
    np.testing.assert_allclose(cosine, 1, atol=1e-6)
    balls = dw.SphereSet("s", vertices, 0.25, "clay").placed(scale=2, translate=(0, 1, 0)).as_placed()
    np.testing.assert_allclose(balls.centres, 2 * vertices + [0, 1, 0], atol=1e-6)
    np.testing.assert_allclose(balls.radii, 0.5)
    with pytest.raises(dw.SceneError, match="scale = .* is not the same along all axes"):
        dw.SphereSet("s", vertices, 0.25, "clay").placed(scale=(1, 2, 1))


# Derivatives.


@pytest.mark.parametrize("shading", ["flat", "phong"])
def test_a_picture_is_differentiable_in_the_vertices(shading):
    """Where no edge moves: a large plate that tilts and bends, in float64 against a central difference."""
    x, z = np.meshgrid(np.linspace(-4, 4, 7), np.linspace(-4, 4, 7), indexing="ij")
    vertices = np.stack([x, 0.1 * np.sin(x) * np.cos(z), z], axis=-1).reshape(-1, 3)
    first = (np.arange(6)[:, None] * 7 + np.arange(6)).ravel()
    faces = np.concatenate(
        [np.stack(t, axis=1) for t in ([first, first + 1, first + 8], [first, first + 8, first + 7])]
    )
    camera = dw.Camera(look_from=(0, 2, 1.5), look_at=(0, 0, 0), up=(0, 1, 0), vfov_deg=40, width=8, height=6)
    base = dw.Scene(
        objects=[dw.Mesh("plate", vertices, faces, "clay", shading=shading)],
        materials={"clay": dw.Material(k_d=0.7, k_h=0.3, phong_exponent=5, k_s=0.4)},
        lights=[dw.PointLight((1, 3, 1), (1, 1, 1))],
        background=SKY,
        max_depth=2,
        precision="float64",
    )
    along = 0.3 * np.random.default_rng(1).normal(size=vertices.shape)

    def image(step):
        moved = dw.replace_parameter(base, "object.plate.vertices", vertices + step * along)
        return dw.render(moved, camera)

    found = np.asarray(jax.jvp(image, (0.0,), (1.0,))[1])
    step = 1e-6
    expected = np.asarray((image(step) - image(-step)) / (2 * step))
    assert np.isfinite(found).all() and abs(expected).max() > 0.05
    off = abs(found - expected).max(axis=-1) / abs(expected).max()
    assert np.mean(off < 1e-5) > 0.9


# Many of them, and pictures on them.


def test_spheres_are_as_many_single_ones():
    rng = np.random.default_rng(3)
    centres, radii = rng.uniform(-0.9, 0.9, (40, 3)), rng.uniform(0.05, 0.25, 40)
    single = [dw.Sphere(f"s{k}", c, r, "clay") for k, (c, r) in enumerate(zip(centres, radii, strict=True))]
    together = dw.SphereSet("many", centres, radii, "clay")
    np.testing.assert_array_equal(picture(together), picture(*single))


def test_a_picture_by_coordinates_of_the_mesh_is_that_of_the_plane():
    """A board of two triangles with u and v at its corners, against the same picture laid over a polygon."""
    corners = np.asarray([[-1.5, -1, 0], [1.5, -1, 0], [1.5, 1, 0], [-1.5, 1, 0]])
    texels = np.random.default_rng(4).uniform(0.1, 0.9, (4, 6, 3))
    camera = dw.Camera(look_from=(0.3, 0.2, 4), look_at=(0, 0, 0), up=(0, 1, 0), vfov_deg=35, width=24, height=18)

    def seen(thing, **mapping):
        one = dw.Scene(
            objects=[thing],
            materials={"paint": dw.Material(k_a=1.0, k_a_texture="picture", k_d=0, k_h=0)},
            textures={"picture": dw.ImageTexture(texels, wrap="clamp", **mapping)},
        )
        return np.asarray(dw.render(one, camera))

    mesh = dw.Mesh("board", corners, [[0, 1, 2, 3]], "paint", uvs=[[0, 0], [1, 0], [1, 1], [0, 1]])
    flat = dict(mapping="planar", origin=corners[0], edge_u=(3, 0, 0), edge_v=(0, 2, 0))
    one, other = seen(mesh, mapping="uv"), seen(dw.Polygon("board", corners, "paint"), **flat)
    np.testing.assert_allclose(one, other, atol=1e-5)
    assert other.std() > 0.05
    with pytest.raises(dw.SceneError, match="'board' .* has no texture coordinates"):
        seen(dw.Polygon("board", corners, "paint"), mapping="uv")
