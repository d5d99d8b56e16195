"""Cameras by pose, focal length, principal point, crop and distortion, and those of parallel rays.

Expected values are OpenCV's projection (calib3d, "Detailed Description"), written out here the other way round: a point
of the world goes to a pixel, and the ray through that pixel must pass through the point.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted._errors import SceneNote
from diffwhitted.formats import scene_text
from diffwhitted.scene import near

WIDTH, HEIGHT = 80, 60
FOCAL, MIDDLE = (82.4, 79.0), (25.0, 36.0)
DISTORTION = (-0.28, 0.09, 0.004, -0.003)
EYE = np.asarray([0.3, -0.2, 4.0])
# A turn about (1, 2, 3) by 0.4 radians (Rodrigues).
AXIS = np.asarray([1.0, 2.0, 3.0]) / np.sqrt(14)
SKEW = np.cross(np.eye(3), AXIS)
TURN = np.eye(3) - np.sin(0.4) * SKEW + (1 - np.cos(0.4)) * SKEW @ SKEW
SIGNS = {"opengl": np.diag([1.0, 1.0, 1.0]), "opencv": np.diag([1.0, -1.0, -1.0])}
"""The axes of OpenGL in those of the convention."""


def pose_of(convention="opengl", rotation=TURN, place=EYE) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation @ SIGNS[convention], place
    return pose


def pixel_of(point, focal=FOCAL, middle=MIDDLE, distortion=(0, 0, 0, 0)):
    """OpenCV's projection of a point of the world, by the camera at EYE turned by TURN."""
    right, up, backwards = TURN.T @ (np.asarray(point) - EYE)
    x, y = right / -backwards, -up / -backwards
    k1, k2, p1, p2 = distortion
    r2 = x**2 + y**2
    radial = 1 + k1 * r2 + k2 * r2**2
    bent = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2), y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y
    return tuple(f * b + c for f, b, c in zip(focal, bent, middle, strict=True))


def points() -> np.ndarray:
    """Points of the world in front of the camera, some way off its axis."""
    ahead = np.asarray([[0.0, 0, -3], [0.5, 0.4, -2], [-0.6, 0.3, -2.5], [1.1, -0.7, -3], [-0.1, -0.9, -2]])
    return ahead @ TURN.T + EYE


def misses(camera, pixel, point) -> float:
    """How far the ray through a pixel passes by a point, metres."""
    ray = camera.rays(*(jnp.asarray([c]) for c in pixel))
    origin, way = (np.asarray(v.stacked(), np.float64)[0] for v in (ray.origin, ray.direction))
    assert np.dot(way, np.asarray(point) - origin) > 0
    return float(np.linalg.norm(np.cross(way, np.asarray(point) - origin)))


def by_pose(convention="opengl", **keys):
    keys = {"focal": FOCAL, "principal_point": MIDDLE, "width": WIDTH, "height": HEIGHT} | keys
    return live(dw.Camera.from_pose(pose_of(convention), convention, **keys))


def live(camera):
    """A camera in a computation, where its numbers are JAX's."""
    return jax.tree.map(jnp.asarray, camera)


@pytest.mark.parametrize("convention", SIGNS)
@pytest.mark.parametrize("distortion", [None, DISTORTION, (0.3, 0.1, 0, 0)], ids=["straight", "barrel", "pincushion"])
@pytest.mark.parametrize("crop", [None, (7, 5, 40, 30)], ids=["full", "crop"])
def test_the_ray_through_the_pixel_of_a_point_passes_through_it(convention, distortion, crop):
    camera = by_pose(convention, distortion=distortion, crop=crop)
    for point in points():
        column, row = pixel_of(point, distortion=distortion or (0, 0, 0, 0))
        left, top = crop[:2] if crop else (0, 0)
        assert misses(camera, (column - left, row - top), point) < 1e-9


def test_an_angle_of_view_bends_as_the_focal_length_that_it_stands_for():
    vfov = 2 * np.rad2deg(np.arctan(HEIGHT / 2 / 70.0))
    camera = by_pose(vfov_deg=vfov, focal=None, distortion=DISTORTION)
    for point in points():
        assert misses(camera, pixel_of(point, (70.0, 70.0), distortion=DISTORTION), point) < 1e-9


def test_what_is_behind_a_distortion_is_said_before_a_ray_is_traced():
    """x (1 - 0.3 x^2) is at most 0.7027, at x = 1.054: 30 pixels at a focal length of 42.7."""
    wide = {"principal_point": None, "width": 60, "height": 1}
    by_pose(focal=(44, 44), distortion=(-0.3, 0, 0, 0), **wide)
    with pytest.raises(dw.SceneError, match=r"distortion = \[-0.3, 0, 0, 0\] has no inverse at column 0, row"):
        by_pose(focal=(42, 42), distortion=(-0.3, 0, 0, 0), **wide)
    by_pose(focal=(42, 42), distortion=(-0.3, 0, 0, 0), **wide, crop=(2, 0, 56, 1))


def test_rays_are_finite_also_where_there_is_no_inverse():
    camera = by_pose(distortion=DISTORTION)
    place = jnp.linspace(-4000, 4000, 41)

    def rays(k):
        return eqx.tree_at(lambda c: c.distortion, camera, k).rays(place, place[::-1]).direction.stacked()

    for k in (DISTORTION, (-2.0, 1.0, 0.3, 0.2), (0.0, -5.0, 0.0, 0.0)):
        value, slope = jax.jvp(rays, (jnp.asarray(k),), (jnp.ones(4),))
        assert np.isfinite(value).all() and np.isfinite(slope).all()


def test_a_crop_is_a_window_of_the_full_picture():
    full = by_pose(distortion=DISTORTION)
    part = by_pose(distortion=DISTORTION, crop=(7, 5, 40, 30))
    assert (part.width, part.height) == (40, 30)
    row, column = (jnp.asarray(c.ravel() + 0.5, jnp.float32) for c in np.mgrid[:30, :40])
    whole, window = full.rays(column + 7, row + 5), part.rays(column, row)
    assert eqx.tree_equal(whole, window)


def ball(*cameras, centre=(0, 0, 0), **settings) -> dw.Scene:
    """A white ball of radius 0.6 before black, without shading."""
    return dw.Scene(
        objects=[dw.Sphere("ball", centre, 0.6, "white")],
        materials={"white": dw.Material(k_a=1.0, k_d=0.0, highlight="off")},
        cameras={f"camera_{k}": camera for k, camera in enumerate(cameras)},
        **settings,
    )


def test_the_picture_of_a_crop_is_that_part_of_the_picture():
    keys = {"width": 16, "height": 12, "up": (0.1, 1, 0)}
    full = dw.Camera((0, 0.4, 2), (0, 0, 0), 40, **keys)
    part = dw.Camera((0, 0.4, 2), (0, 0, 0), 40, **keys, crop=(3, 2, 9, 7))
    scene = ball(full, part)
    np.testing.assert_array_equal(dw.render(scene, part), dw.render(scene, full)[2:9, 3:12])


# Parallel rays.


@pytest.mark.slow
def test_parallel_rays_show_a_ball_in_its_size_at_any_distance():
    """Diameter 1.2 of 2 metres is 0.6 of the rows; its area is pi 0.6^2, to the accuracy of filtered edges."""
    camera = dw.OrthographicCamera((0, 0, 50), (0, 0, 0), 2.0, 32, 24)
    scene = ball(camera)
    image = np.asarray(dw.render(scene, camera, footprint=1))[..., 0]
    metres = 2 / 24
    assert image[12].sum() * metres == pytest.approx(1.2, abs=0.02)
    assert image[:, 16].sum() * metres == pytest.approx(1.2, abs=0.02)
    assert image.sum() * metres**2 == pytest.approx(np.pi * 0.6**2, rel=2e-3)


def test_parallel_rays_begin_on_the_plane_through_look_from():
    eye, aim = np.asarray([1.0, 2.0, 3.0]), np.asarray([1.0, 0.0, 3.0])
    camera = live(dw.OrthographicCamera(eye, aim, 3.0, 8, 6, up=(0, 0, 1), principal_point=(1.0, 2.0)))
    ray = camera.rays(jnp.asarray([1.0, 5.0]), jnp.asarray([2.0, 0.5]))
    # Looking along -y with z up, the right is -x.
    np.testing.assert_allclose(ray.origin.stacked(), [eye, eye + [-4 * 0.5, 0, 1.5 * 0.5]], atol=1e-12)
    np.testing.assert_allclose(ray.direction.stacked(), [[0, -1, 0], [0, -1, 0]], atol=1e-12)
    # What lies behind that plane is not seen.
    behind = dw.OrthographicCamera((0, 0, -2), (0, 0, -3), 2.0, 4, 3)
    with pytest.warns(SceneNote, match="entirely black"):
        assert not np.asarray(dw.render(ball(behind), behind)).any()


def test_no_body_that_parallel_rays_may_begin_in_counts_as_one_that_stands_alone():
    """`render_with_bound` leaves total internal reflection out of spheres that no ray begins in."""
    camera = dw.OrthographicCamera((0, 5, 0), (0, 0, 0), 2.0, 8, 6, up=(0, 0, 1))
    middle, radius = camera.starts()
    np.testing.assert_allclose(middle, (0, 5, 0), atol=1e-12)
    assert radius == pytest.approx(np.hypot(1, 4 / 3))


# Sizes, far places, derivatives, names.

KINDS = {
    "angle": lambda **keys: dw.Camera((0, 0.4, 5), (0, 0, 0), 40, **keys),
    "focal": lambda **keys: dw.Camera((0, 0.4, 5), (0, 0, 0), focal=FOCAL, principal_point=MIDDLE, **keys),
    "bent": lambda **keys: dw.Camera((0, 0.4, 5), (0, 0, 0), focal=FOCAL, distortion=DISTORTION, **keys),
    "parallel": lambda **keys: dw.OrthographicCamera((0, 0.4, 5), (0, 0, 0), 3.0, principal_point=MIDDLE, **keys),
}
SIZE = {"width": WIDTH, "height": HEIGHT}


@pytest.mark.parametrize("crop", [None, (6, 4, 40, 30), (5, 3, 41, 30)], ids=["full", "even", "odd"])
@pytest.mark.parametrize("kind", KINDS)
def test_another_size_is_the_same_view(kind, crop):
    """Places at the same fraction of the picture, or of its height where it is of another shape."""
    camera = live(KINDS[kind](**SIZE, crop=crop))
    column, row = jnp.asarray([0.0, 3.0, 20.5, 40.0]), jnp.asarray([0.0, 9.0, 3.5, 30.0])
    twice = camera.resized(height=2 * camera.height)
    for mine, other in zip(
        jax.tree.leaves(camera.rays(column, row)), jax.tree.leaves(twice.rays(2 * column, 2 * row)), strict=True
    ):
        np.testing.assert_allclose(other, mine, atol=1e-7)
    wider = camera.resized(camera.width + 10, camera.height)
    for mine, other in zip(
        jax.tree.leaves(camera.rays(column, row)), jax.tree.leaves(wider.rays(column + 5, row)), strict=True
    ):
        np.testing.assert_allclose(other, mine, atol=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_far_from_the_origin_a_camera_sees_what_it_sees_here(kind):
    by = np.asarray([4e5, 0, -3e5])
    camera, place = KINDS[kind](**SIZE), (jnp.asarray([3.5]), jnp.asarray([9.5]))
    scene = ball(camera.moved(by), centre=by)
    moved, seen = near(scene, scene.cameras["camera_0"])
    assert seen.look_from.dtype == np.float32
    here, there = (live(one).rays(*place) for one in (camera, seen))
    to_ball = np.asarray(moved.objects[0].centre) - np.asarray(there.origin.stacked())
    np.testing.assert_allclose(to_ball, -np.asarray(here.origin.stacked()), atol=2e-6)
    np.testing.assert_allclose(there.direction.stacked(), here.direction.stacked(), atol=2e-6)


@pytest.mark.parametrize("kind", ["focal", "bent", "parallel"])
def test_rays_and_footprints_are_differentiated(kind):
    """In all numbers of a camera at once: against a central difference, and forward against reverse."""
    camera = live(KINDS[kind](**SIZE))
    column, row = jnp.asarray([0.0, 3.0, 20.5, 79.0]), jnp.asarray([0.0, 59.0, 30.5, 30.0])
    random = np.random.default_rng(1)
    way = jax.tree.map(lambda number: jnp.asarray(random.normal(size=number.shape)), camera)

    def seen(camera):
        footprint = camera.footprint(column, row, jnp.asarray(1.0))
        leaves = jax.tree.leaves((camera.rays(column, row), footprint.across, footprint.down))
        return jnp.stack(jnp.broadcast_arrays(*leaves))

    def derivatives(camera):
        def moved(by):
            return seen(jax.tree.map(lambda number, along: number + by * along, camera, way))

        central = (moved(1e-6) - moved(-1e-6)) / 2e-6
        _, forward = jax.jvp(seen, (camera,), (way,))
        weights = jnp.cos(jnp.arange(forward.size, dtype=float)).reshape(forward.shape)
        back = jax.vjp(seen, camera)[1](weights)[0]
        parts = jax.tree.map(lambda slope, along: (slope * along).sum(), back, way)
        return central, forward, back, sum(jax.tree.leaves(parts)), (weights * forward).sum()

    central, forward, back, one, other = jax.jit(derivatives, compiler_options=SOON_COMPILED)(camera)
    assert all(np.abs(slope).max() > 1e-4 for slope in jax.tree.leaves(back))
    np.testing.assert_allclose(forward, central, atol=1e-8 * float(jnp.abs(central).max()))
    np.testing.assert_allclose(one, other, rtol=1e-9)


def test_the_numbers_of_a_camera_have_names():
    scene = ball(KINDS["bent"](**SIZE), KINDS["parallel"](**SIZE))
    names = [parameter.name for parameter in dw.parameters(scene)]
    assert {"camera.camera_0.focal", "camera.camera_0.distortion", "camera.camera_1.view_height"} <= set(names)
    assert "camera.camera_0.vfov_deg" not in names and "camera.camera_0.principal_point" not in names
    assert float(dw.parameter_value(scene, "camera.camera_0.distortion.p1")) == pytest.approx(DISTORTION[2])
    changed = dw.replace_parameter(scene, "camera.camera_0.focal.y", 50.0)
    np.testing.assert_allclose(changed.cameras["camera_0"].focal, (FOCAL[0], 50.0))
    with pytest.raises(dw.SceneError, match="states no vfov_deg"):
        dw.parameter_value(scene, "camera.camera_0.vfov_deg")
    with pytest.raises(dw.SceneError, match="camera 'camera_0': distortion .* has no inverse"):
        dw.replace_parameter(scene, "camera.camera_0.distortion.k1", -2.0)


def test_a_cropped_camera_is_changed_by_name_as_it_stands():
    scene = ball(KINDS["angle"](**SIZE, crop=(6, 4, 40, 30)))
    camera = dw.replace_parameter(scene, "camera.camera_0.vfov_deg", 30.0).cameras["camera_0"]
    assert (camera.full, camera.crop, camera.width) == ((WIDTH, HEIGHT), (6, 4, 40, 30), 40)


# Scene files.

VIEW = "look_from = [0, 0, 5]\nlook_at = [0, 0, 0]\n"


def parsed(keys: str) -> dw.Scene:
    return dw.parse_scene(f"[[camera]]\nwidth = {WIDTH}\nheight = {HEIGHT}\n{keys}\n")


@pytest.mark.parametrize(
    "keys",
    [
        f"{VIEW}vfov_deg = 40\ncrop = [6, 4, 40, 30]",
        f"{VIEW}focal = [82.4, 79]\nprincipal_point = [25, 36]\ndistortion = [-0.2, 0.05, 0.001, 0]",
        f'{VIEW}type = "orthographic"\nview_height = 2.5\nprincipal_point = [25, 36]\ncrop = [6, 4, 40, 30]',
        f'{VIEW}type = "perspective"\nvfov_deg = 40',
        f'pose = {pose_of("opencv").tolist()}\nconvention = "opencv"\nfocal = [82.4, 79]',
    ],
    ids=["crop", "focal", "parallel", "perspective", "pose"],
)
def test_cameras_are_saved_and_loaded(keys):
    scene = parsed(keys)
    assert eqx.tree_equal(dw.parse_scene(scene_text(scene)), scene)


def test_a_pose_in_a_file_is_the_view_that_it_stands_for():
    camera = parsed(f'pose = {pose_of("opencv").tolist()}\nconvention = "opencv"\nvfov_deg = 40').cameras["main"]
    np.testing.assert_allclose(camera.look_from, EYE, rtol=1e-6)
    ahead = np.asarray(camera.look_at, np.float64) - camera.look_from
    np.testing.assert_allclose(ahead / np.linalg.norm(ahead), -TURN[:, 2], atol=1e-6)
    np.testing.assert_allclose(camera.up, TURN[:, 1], atol=1e-6)


def off(row=1, column=2, by=0.01, **keys) -> str:
    pose = pose_of(**keys)
    pose[row, column] += by
    return f"pose = {pose.tolist()}\nvfov_deg = 40"


FAULTS = {
    "not orthonormal": (off(), "R^T R is off by", "allowed is 0.0001"),
    "scaled": (off(by=0, rotation=2 * TURN), "columns have the lengths [2, 2, 2]", "no scale"),
    "mirror": (off(by=0, rotation=TURN @ np.diag([1, 1, -1])), "mirrors", "determinant 1"),
    "last row": (off(3, 0), "the last row of pose is [0.01, 0, 0, 1]", "[0, 0, 0, 1]"),
    "by columns": (f"pose = {pose_of().T.tolist()}\nvfov_deg = 40", "transpose it"),
    "both": (f"{off(by=0)}\nup = [0, 1, 0]", "pose says where it stands, and so does up"),
    "no place": ("vfov_deg = 40", "look_from is missing", "or a pose"),
    "convention alone": (f'{VIEW}vfov_deg = 40\nconvention = "opencv"', "there is none"),
    "no such convention": (f'{off(by=0)}\nconvention = "openvc"', "convention", 'Did you mean "opencv"?'),
    "two lengths": (f"{VIEW}vfov_deg = 40\nfocal = [50, 50]", "vfov_deg and focal are both stated"),
    "no length": (VIEW, "vfov_deg is missing", "focal = [fx, fy]"),
    "negative": (f"{VIEW}focal = [50, -50]", "focal = [50, -50]", "allowed is > 0"),
    "one length": (f"{VIEW}focal = 50", "focal = 50", "a list of 2 numbers > 0"),
    "of another program": (f"{VIEW}vfov_deg = 40\ncx = 25", "unknown key cx", 'Did you mean "principal_point"?'),
    "matrix": ("vfov_deg = 40\nmatrix = [[1]]", "unknown key matrix", 'Did you mean "pose"?'),
    "outside": (f"{VIEW}vfov_deg = 40\ncrop = [50, 0, 40, 30]", "crop = [50, 0, 40, 30]", "within the 80 x 60"),
    "not inverse": (f"{VIEW}focal = [30, 30]\ndistortion = [-0.5, 0, 0, 0]", "distortion = [-0.5", "no inverse"),
    "no such type": (f'{VIEW}type = "fisheye"\nvfov_deg = 40', "perspective", "orthographic"),
    "of another kind": (f'{VIEW}type = "orthographic"\nview_height = 2\nvfov_deg = 40', "unknown key vfov_deg"),
    "no height": (f'{VIEW}type = "orthographic"', "view_height is missing", "a number > 0"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_what_is_wrong_with_a_camera_is_a_sentence(fault):
    text, *parts = FAULTS[fault]
    with pytest.raises(dw.SceneError) as error:
        parsed(text)
    assert all(part in str(error.value) for part in ("[[camera]]", *parts)), str(error.value)
