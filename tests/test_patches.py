"""Bicubic patches: against surfaces of known equations, against meshes, and at sides that are one point."""

import functools
import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.geometry import NOTHING, Departure, Ray
from diffwhitted.numerics._vector import vec3
from diffwhitted.shapes._patches import CELLS, patches_of
from diffwhitted.standard._teapot import control_points, pot

STEPS = (np.arange(4) * 2 / 3 - 1).tolist()
SADDLE = np.asarray([[[x, y, x * y] for x in STEPS] for y in STEPS])
"""z = x y over a square, from -1 to 1: a bilinear patch, its degree raised; u = (x + 1) / 2, v = (y + 1) / 2."""
SLOPE = np.asarray([[[x, y, 0.3 * x + 0.2] for x in STEPS] for y in STEPS])
BUMPY = SADDLE * [1, 1, 0.2] + 0.15 * np.random.default_rng(3).normal(size=(4, 4, 3))
CAMERA = dw.Camera(look_from=(0.1, 0.2, 4), look_at=(0, 0, 0), up=(0, 1, 0), vfov_deg=20, width=8, height=6)


def rays(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Origins and unit directions (n, 3), from above and from below, towards the inner part of a patch."""
    rng = np.random.default_rng(seed)
    origin = rng.normal(size=(count, 3)) + np.where(rng.random((count, 1)) < 0.7, 1, -1) * [0, 0, 5]
    way = np.append(rng.uniform(-0.7, 0.7, (count, 2)), np.zeros((count, 1)), axis=1) - origin
    return origin, way / np.linalg.norm(way, axis=1, keepdims=True)


def ray_of(origin, way, dtype=jnp.float64) -> Ray:
    return Ray(vec3(jnp.asarray(origin, dtype)), vec3(jnp.asarray(way, dtype)))


def patch_at(points, primitive, dtype=jnp.float64):
    """The triangle that each ray meets, with its patch."""
    family = patches_of(jnp.asarray(points, dtype).reshape(-1, 16, 3))
    return jax.tree.map(lambda a: a[primitive], family)


soon = functools.partial(jax.jit, compiler_options=SOON_COMPILED)


@soon
def met(points, ray: Ray):
    """The first triangle, and what is known of the patch there."""
    count = ray.origin.shape
    free = Departure(jnp.full(count, NOTHING, jnp.int32), jnp.zeros(count, bool))
    _, primitive, _ = patches_of(points.reshape(-1, 16, 3)).nearest(ray, free)
    member = patch_at(points, jnp.maximum(primitive, 0), points.dtype)
    distance, normal, point, enters = member.surface(ray, None)
    return primitive, distance, normal.stacked(), jnp.stack(member.uv(point), axis=-1), enters


@pytest.mark.parametrize("dtype, close", [(jnp.float64, 1e-11), (jnp.float32, 2e-5)])
def test_a_saddle_is_met_where_its_equation_says(dtype, close):
    """z = x y along a ray is a quadratic equation in the distance."""
    origin, way = rays(200)
    (ox, oy, oz), (dx, dy, dz) = origin.T, way.T
    a, b, c = dx * dy, ox * dy + oy * dx - dz, ox * oy - oz
    roots = np.stack([(-b + s * np.sqrt(b * b - 4 * a * c)) / (2 * a) for s in (1, -1)])
    places = origin + roots[..., None] * way
    there = (abs(places[..., :2]) <= 1).all(axis=-1) & (roots > 0)
    expected = np.where(there, roots, np.inf).min(axis=0)
    primitive, distance, normal, uv, enters = met(jnp.asarray(SADDLE, dtype), ray_of(origin, way, dtype))
    assert (np.asarray(primitive) >= 0).all()
    np.testing.assert_allclose(distance, expected, rtol=close)
    x, y, _ = (origin + expected[:, None] * way).T
    square = np.stack([-y, -x, np.ones_like(x)], axis=-1)
    np.testing.assert_allclose(normal, square / np.linalg.norm(square, axis=1, keepdims=True), atol=3 * close)
    np.testing.assert_allclose(uv, np.stack([x + 1, y + 1], axis=-1) / 2, atol=3 * close)
    np.testing.assert_array_equal(enters, (way * square).sum(axis=1) < 0)


def test_a_plane_is_a_plane():
    origin, way = rays(60, 2)
    _, distance, normal, _, _ = met(jnp.asarray(SLOPE), ray_of(origin, way))
    square = np.asarray([-0.3, 0, 1])
    np.testing.assert_allclose(distance, (0.2 - origin @ square) / (way @ square), rtol=1e-12)
    np.testing.assert_allclose(normal, np.tile(square / np.linalg.norm(square), (60, 1)), atol=1e-12)


def test_a_patch_is_nearer_to_its_surface_than_its_triangles():
    """By bisection along the ray of the height over the point with the same x and y, on a patch that is a graph."""
    control = SADDLE.copy()
    control[..., 2] = 0.4 * np.random.default_rng(5).normal(size=(4, 4))
    origin, way = rays(40, 6)
    primitive, distance, *_ = met(jnp.asarray(control), ray_of(origin, way))

    def height(x, y):
        def cubic(t):
            s = 1 - t
            return np.stack([s**3, 3 * t * s**2, 3 * t**2 * s, t**3], axis=-1)

        return np.einsum("...j,...i,ij->...", cubic((x + 1) / 2), cubic((y + 1) / 2), control[..., 2])

    x, y, z = (origin + np.asarray(distance)[:, None] * way).T
    assert (np.asarray(primitive) >= 0).all() and abs(z - height(x, y)).max() < 1e-12
    corners = patch_at(control, primitive).corners
    flat = np.mean([np.asarray(c.stacked()) for c in corners], axis=0)
    assert abs(flat[:, 2] - height(flat[:, 0], flat[:, 1])).max() > 1e-4


def test_derivatives_in_control_points_and_rays():
    """Of distance, normal and u, v: forward against a central difference and against reverse."""
    origin, way = rays(12, 7)
    primitive = met(jnp.asarray(BUMPY), ray_of(origin, way))[0]
    rng = np.random.default_rng(8)
    values = tuple(map(jnp.asarray, (BUMPY, origin, way)))
    along = tuple(jnp.asarray(0.1 * rng.normal(size=v.shape)) for v in values)

    def seen(values):
        points, origin, way = values
        member, ray = patch_at(points, primitive), ray_of(origin, way)
        distance, normal, point, _ = member.surface(ray, None)
        return jnp.stack([distance, normal.x, normal.y, normal.z, *member.uv(point)])

    weights, image = jnp.asarray(rng.normal(size=(6, 12))), soon(seen)
    found = soon(lambda values: jax.jvp(seen, (values,), (along,))[1])(values)
    ends = [image(tuple(v + s * a for v, a in zip(values, along, strict=True))) for s in (1e-6, -1e-6)]
    np.testing.assert_allclose(found, (ends[0] - ends[1]) / 2e-6, rtol=1e-5, atol=1e-7)
    back = soon(jax.grad(lambda values: (seen(values) * weights).sum()))(values)
    total = sum(float((b * a).sum()) for b, a in zip(back, along, strict=True))
    assert total == pytest.approx(float((found * weights).sum()), rel=1e-9)


def test_where_a_side_is_one_point_the_normal_is_that_of_beside_it():
    """The knob of the teapot's lid, in float32: its top is flat, and four patches end there in one point."""
    control, dtype = control_points(), jnp.float32
    control = control[[control[k, ..., 2].max() == control[..., 2].max() for k in range(32)]]
    top = control[..., 2].max()
    places = np.asarray([[0, 0], [1e-6, 2e-6], [1e-4, -1e-4], [0.01, 0.02]])
    origin = np.append(places, np.full((4, 1), top + 2), axis=1)
    ray = ray_of(origin, np.tile([0, 0, -1.0], (4, 1)), dtype)

    def seen(points):
        primitive, distance, normal, *_ = met.__wrapped__(points, ray)
        return distance, normal, primitive

    distance, normal, primitive = soon(seen)(jnp.asarray(control, dtype))
    assert (np.asarray(primitive) >= 0).all()
    np.testing.assert_allclose(distance, 2, atol=2e-3)
    np.testing.assert_allclose(normal, np.tile([0, 0, 1.0], (4, 1)), atol=0.06)
    slope = soon(jax.grad(lambda points: sum(a.sum() for a in seen(points)[:2])))(jnp.asarray(control, dtype))
    assert np.isfinite(slope).all() and abs(slope).max() > 0.1


# In scenes.


def scene(thing, **more) -> dw.Scene:
    return dw.Scene(
        objects=[thing],
        materials={"clay": dw.Material(k_a=0.1, k_d=(0.7, 0.5, 0.4), k_h=0.3, phong_exponent=10)},
        lights=[dw.PointLight((2, 3, 4), (1, 1, 1))],
        cameras={"main": CAMERA},
        background=dw.ConstantBackground((0.2, 0.3, 0.5)),
        **more,
    )


def test_the_teapot_is_that_of_its_mesh():
    """32 patches against 64 k triangles with the normals of the patches."""
    camera = dw.Camera((3.6, 5.2, 3.6), (0.1, 0, 1.35), up=(0, 0, 1), vfov_deg=33, width=48, height=36)
    vertices, normals, faces = pot(32)
    things = dw.Patch("pot", control_points(), "clay"), dw.Mesh("pot", vertices, faces, "clay", normals=normals)
    one, other = (np.asarray(dw.render(scene(thing), camera)) for thing in things)
    off = abs(one - other).max(axis=-1)
    assert np.median(off) < 2e-4 and np.quantile(off, 0.97) < 0.01 and np.mean(off > 0.05) < 0.01
    assert other.std() > 0.1


def test_a_picture_is_differentiable_in_control_points():
    """Where no edge moves: a patch that fills the picture, in float64 against a central difference, within `jit`."""
    base = scene(dw.Patch("sheet", 1.5 * BUMPY, "clay"), precision="float64")
    rng = np.random.default_rng(9)
    along, weights = jnp.asarray(rng.normal(size=(16, 3))), jnp.asarray(rng.normal(size=(6, 8, 3)))
    points = jnp.asarray(base.objects[0].control_points)

    def total(points):
        return (dw.render(dw.replace_parameter(base, "object.sheet.control_points", points), CAMERA) * weights).sum()

    both = jax.jit(jax.value_and_grad(total), compiler_options=SOON_COMPILED)
    ends = [float(both(points + s * along)[0]) for s in (1e-5, -1e-5)]
    found = float((both(points)[1] * along).sum())
    assert found == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-5) and abs(found) > 0.01


def test_a_texture_by_u_and_v_is_one_laid_over_it():
    texels = np.random.default_rng(4).uniform(0.1, 0.9, (4, 6, 3))

    def seen(**mapping):
        one = dw.Scene(
            objects=[dw.Patch("sheet", SADDLE * [1, 1, 0], "paint")],
            materials={"paint": dw.Material(k_a=1.0, k_a_texture="picture", k_d=0, k_h=0)},
            textures={"picture": dw.ImageTexture(texels, wrap="clamp", **mapping)},
        )
        return np.asarray(dw.render(one, CAMERA))

    flat = dict(mapping="planar", origin=(-1, -1, 0), edge_u=(2, 0, 0), edge_v=(0, 2, 0))
    one, other = seen(mapping="uv"), seen(**flat)
    np.testing.assert_allclose(one, other, atol=1e-5)
    assert other.std() > 0.05


def test_a_transform_takes_the_control_points_along():
    placed = dw.Patch("sheet", SADDLE, "clay").placed(scale=(1, 2, 3), rotate_deg=(0, 90, 0), translate=(1, 2, 3))
    x, y, z = (SADDLE.reshape(-1, 3) * [1, 2, 3]).T
    np.testing.assert_allclose(placed.as_placed().control_points, np.stack([z + 1, y + 2, 3 - x], axis=1), atol=1e-6)
    middle, radius = placed.as_placed().ball()
    assert (np.linalg.norm(placed.as_placed().control_points - middle, axis=1) <= radius + 1e-6).all()


# Files, and what is refused.


def test_patches_come_from_files(tmp_path):
    two = np.stack([SADDLE, SLOPE])
    rows = "\n".join(f"3 3\n{chr(10).join(' '.join(map(repr, p)) for p in one.reshape(-1, 3).tolist())}" for one in two)
    (tmp_path / "two.bpt").write_text(f"2\n{rows}\n")
    vertices = two.reshape(-1, 3).tolist()
    (tmp_path / "two.json").write_text(
        json.dumps({"vertices": vertices, "patches": np.arange(32).reshape(2, 4, 4).tolist()})
    )
    for name in ("two.bpt", "two.json"):
        found = dw.Patch("sheets", material="clay", file=str(tmp_path / name))
        np.testing.assert_array_equal(found.control_points, two.reshape(-1, 3))
        assert found.surfaces == 2 * 2 * CELLS * CELLS
        dw.save_scene(scene(found), tmp_path / "scene.toml")
        assert f'file = "{name}"' in (tmp_path / "scene.toml").read_text()
        again = dw.load_scene(tmp_path / "scene.toml").objects[0]
        np.testing.assert_array_equal(again.control_points, found.control_points.astype(np.float32))
    dw.save_scene(scene(dw.Patch("sheet", SADDLE, "clay")), tmp_path / "own.toml")
    own = (tmp_path / "own.toml").read_text()
    start = own.index("control_points = ")
    rows = f"{own[:start]}control_points = {SADDLE.tolist()}\n{own[own.index('material = ', start) :]}"
    (tmp_path / "rows.toml").write_text(rows)
    for name in ("own.toml", "rows.toml"):
        again = dw.load_scene(tmp_path / name).objects[0]
        np.testing.assert_array_equal(again.control_points, SADDLE.reshape(-1, 3).astype(np.float32))


@pytest.mark.parametrize(
    "how, message",
    [
        ({}, "a patch needs control_points, or a file"),
        ({"control_points": SADDLE[:3].reshape(-1, 3)}, "control_points has 12 entries|12 points; allowed is 16"),
        ({"control_points": np.zeros((17, 3))}, "has 17 points; allowed is 16 for each patch"),
        ({"control_points": np.full((16, 3), np.nan)}, "control_points"),
        ({"file": "none.bpt"}, "there is no such file"),
        ({"file": "bad.obj"}, "ends with '.obj'; allowed is .json, .bpt"),
        ({"file": "short.bpt"}, "2 patches are 100 numbers, and 3 are there"),
        ({"file": "line.bpt"}, "ValueError"),
        ({"file": "bad.json"}, "patch names vertex 16"),
        ({"file": "list.json"}, "allowed is an object with vertices"),
    ],
)
def test_what_is_no_patch_is_refused(how, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in {
        "bad.obj": "", "short.bpt": "2 3 3 1", "line.bpt": "one",
        "bad.json": json.dumps({"vertices": [[0, 0, 0]] * 16, "patches": [[[1, 2, 3, 16]] * 4]}),
        "list.json": "[]",
    }.items():  # fmt: skip
        (tmp_path / name).write_text(text)
    with pytest.raises(dw.SceneError, match=message):
        dw.Patch("sheet", material="clay", **how)


def test_a_patch_is_not_glass():
    """Known or free: rays go on from triangles and from the patch by turns, which is no medium."""
    glass = {"clay": dw.Material(k_t=0.5)}
    one = dw.Scene(objects=[dw.Patch("sheet", SADDLE, "clay")], materials=glass, cameras={"main": CAMERA})
    with pytest.raises(dw.SceneError, match="'sheet': clay.k_t = 0.5, and a patch lets no light through; allowed"):
        dw.render(one, CAMERA)
    with pytest.raises(dw.SceneError, match="'sheet': clay.k_t is free in the fit, and a patch lets no light through"):
        dw.decide_effects(scene(one.objects[0]), free=["clay.k_t"])
