"""Cameras of COLMAP and of transforms.json, read by path and in a scene file.

COLMAP's pose is from world to camera, x_camera = R x_world + t, with R of a quaternion: SciPy turns points by it.
"""

import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import diffwhitted as dw

QUATERNION, SHIFT = np.asarray([0.9, 0.1, -0.3, 0.2]), np.asarray([0.5, -0.4, 3.0])
CAMERAS = """# Camera list with one line of data per camera:
1 SIMPLE_PINHOLE 80 60 70 40 30
2 PINHOLE 80 60 70 71 41 29
3 SIMPLE_RADIAL 80 60 70 40 30 -0.1
4 RADIAL 80 60 70 40 30 -0.1 0.02
5 OPENCV 80 60 70 71 41 29 -0.1 0.02 0.003 -0.004
"""
LENSES = {
    "1": ((70, 70), (40, 30), (0, 0, 0, 0)),
    "2": ((70, 71), (41, 29), (0, 0, 0, 0)),
    "3": ((70, 70), (40, 30), (-0.1, 0, 0, 0)),
    "4": ((70, 70), (40, 30), (-0.1, 0.02, 0, 0)),
    "5": ((70, 71), (41, 29), (-0.1, 0.02, 0.003, -0.004)),
}


def ways(camera, column, row) -> np.ndarray:
    """Directions of the rays through places of the picture, (n, 3)."""
    live = jax.tree.map(jnp.asarray, camera)
    return np.asarray(live.rays(jnp.asarray(column), jnp.asarray(row)).direction.stacked())


def image_line(number, camera, name) -> str:
    return " ".join(map(str, (number, *QUATERNION, *SHIFT, camera, name)))


def images(points="1.5 2.5 -1 3.0 4.0 17") -> str:
    lines = [f"{image_line(k, k, f'shots/IMG {k}.v2.JPG')}\n{points}" for k in (1, 2, 3)]
    return "# Image list\n" + "\n".join([*lines, image_line(4, 4, "0004.png"), "", image_line(5, 5, "0005.png"), ""])


@pytest.fixture
def sparse(tmp_path):
    (tmp_path / "sparse").mkdir()
    (tmp_path / "sparse" / "cameras.txt").write_text(CAMERAS)
    (tmp_path / "sparse" / "images.txt").write_text(images())
    return tmp_path / "sparse"


def test_the_cameras_of_colmap_see_points_where_it_projects_them(sparse):
    found = dw.read_cameras(sparse)
    assert list(found) == ["IMG 1_v2", "IMG 2_v2", "IMG 3_v2", "0004", "0005"]
    turn = Rotation.from_quat(np.roll(QUATERNION, -1))
    for camera, (focal, middle, (k1, k2, p1, p2)) in zip(found.values(), LENSES.values(), strict=True):
        assert (camera.distortion is None) == (not any((k1, k2, p1, p2)))
        for seen in np.asarray([[0.2, -0.1, 1.0], [-0.4, 0.3, 2.0]]):
            point = turn.inv().apply(seen - SHIFT)
            x, y = seen[:2] / seen[2]
            r2 = x * x + y * y
            radial = 1 + k1 * r2 + k2 * r2**2
            across = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
            down = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
            column, row = (np.asarray([f * b + c]) for f, b, c in zip(focal, (across, down), middle, strict=True))
            way = ways(camera, column, row)[0]
            to_point = point - np.asarray(camera.look_from)
            np.testing.assert_allclose(way, to_point / np.linalg.norm(to_point), atol=1e-9)


@pytest.mark.parametrize("points", ["", "1.5 2.5 -1 " * 400])
def test_lines_of_points_are_skipped(sparse, points):
    (sparse / "images.txt").write_text(images(points))
    assert len(dw.read_cameras(sparse / "images.txt")) == 5


def frame(path="images/0001.png", **keys) -> dict:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_quat(np.roll(QUATERNION, -1)).as_matrix(), SHIFT
    return {"file_path": path, "transform_matrix": pose.tolist(), **keys}


def written(folder, **keys):
    path = folder / "transforms.json"
    path.write_text(json.dumps({"w": 80, "h": 60, "camera_angle_x": 1.0, "frames": [frame()]} | keys))
    return path


def test_an_angle_across_is_a_focal_length(tmp_path):
    camera = dw.read_cameras(written(tmp_path))["0001"]
    np.testing.assert_allclose(camera.focal, 40 / np.tan(0.5))
    assert camera.principal_point is None and camera.distortion is None
    np.testing.assert_allclose(camera.look_from, SHIFT)
    # The middle of the picture looks along -z of the pose, its right side is +x and its top +y.
    rotation = Rotation.from_quat(np.roll(QUATERNION, -1)).as_matrix()
    middle, beside, above = ways(camera, [40.0, 41.0, 40.0], [30.0, 30.0, 29.0])
    np.testing.assert_allclose(middle, -rotation[:, 2], atol=1e-9)
    assert (beside - middle) @ rotation[:, 0] > 0.01 and (above - middle) @ rotation[:, 1] > 0.01


def test_what_a_frame_says_goes_before_what_the_file_says(tmp_path):
    own = frame("./b.x/0001.png", fl_x=50, fl_y=51, cx=39, cy=31, k1=-0.05, w=79)
    found = dw.read_cameras(written(tmp_path, frames=[frame("./a/0001.png"), own], fl_x=60).parent)
    assert list(found) == ["a_0001", "b_x_0001"]
    first, second = found.values()
    np.testing.assert_allclose(first.focal, (60, 60))
    np.testing.assert_allclose([*second.focal, *second.principal_point], (50, 51, 39, 31))
    np.testing.assert_allclose(second.distortion, (-0.05, 0, 0, 0))
    assert (second.width, second.height) == (79, 60)


def test_a_picture_tells_its_size_where_the_file_does_not(tmp_path):
    dw.write_image(tmp_path / "r_0.png", np.zeros((6, 8, 3), np.float32))
    path = tmp_path / "transforms_train.json"
    path.write_text(json.dumps({"camera_angle_x": 1.0, "frames": [frame("./r_0")]}))
    camera = dw.read_cameras(path)["r_0"]
    assert (camera.width, camera.height) == (8, 6)


SCENE = """
[[camera]]
name = "main"
look_from = [0, 0, 5]
look_at = [0, 0, 0]
vfov_deg = 40
width = 8
height = 6
"""


def test_a_scene_takes_cameras_from_beside_its_file(sparse):
    path = sparse.parent / "scene.toml"
    path.write_text('cameras = "sparse/"\n' + SCENE)
    scene = dw.load_scene(path)
    assert list(scene.cameras) == ["main", "IMG 1_v2", "IMG 2_v2", "IMG 3_v2", "0004", "0005"]
    dw.save_scene(scene, path)
    again = dw.load_scene(path)
    np.testing.assert_array_equal(again.cameras["0005"].focal, scene.cameras["0005"].focal)
    path.write_text('cameras = "sparse"\n' + SCENE.replace('"main"', '"0004"'))
    with pytest.raises(dw.SceneError, match='camera "0004": a .*and one of cameras have this name; rename'):
        dw.load_scene(path)


@pytest.mark.parametrize(
    "text, parts",
    [
        ('cameras = "nowhere"', ('cameras = "nowhere"', "no such file or folder", "cameras.txt and images.txt")),
        ("cameras = 5", ("cameras = 5; allowed is text in quotes", "path")),
        ("[[cameras]]\nname = 'a'", ("Did you mean [[camera]]?",)),
        ('[scene]\ncameras = "sparse"', ("unknown key cameras", "above the first table")),
    ],
)
def test_a_path_that_is_none_is_a_sentence(text, parts):
    with pytest.raises(dw.SceneError) as error:
        dw.parse_scene(text)
    assert all(part in str(error.value) for part in parts), str(error.value)


OF_COLMAP = {
    "model": (
        "cameras.txt",
        "1 OPENCV_FISHEYE 80 60 1 1 1 1 0 0 0 0",
        ("line 1", "OPENCV_FISHEYE is not known", "OPENCV"),
    ),
    "numbers": ("cameras.txt", "1 PINHOLE 80 60 70 40 30", ("3 numbers", "4: fx fy cx cy")),
    "word": ("cameras.txt", "1 PINHOLE 80 60 70 40 30 x", ("line 1", "not all numbers")),
    "size": ("cameras.txt", "1 PINHOLE 0 60 70 70 40 30", ("width = 0", "from 1 to 32768")),
    "no camera": (
        "cameras.txt",
        "9 PINHOLE 80 60 70 70 40 30",
        ("images.txt: line 2", "camera 1 is not in cameras.txt"),
    ),
    "no turn": ("images.txt", "1 0 0 0 0 1 2 3 1 a.png", ("QW QX QY QZ", "any but zero")),
    "short": ("images.txt", "1 1 0 0 0 1 2 3 1", ("9 words", "IMAGE_ID")),
    "empty": ("images.txt", "# nothing", ("no picture in it",)),
}


@pytest.mark.parametrize("case", OF_COLMAP)
def test_what_is_wrong_with_a_model_of_colmap_is_a_sentence(sparse, case):
    name, text, parts = OF_COLMAP[case]
    (sparse / name).write_text(text)
    with pytest.raises(dw.SceneError) as error:
        dw.read_cameras(sparse)
    assert all(part in str(error.value) for part in (name if case != "no camera" else "", *parts)), str(error.value)


def test_a_binary_model_is_refused_with_the_way_out(tmp_path):
    (tmp_path / "cameras.bin").write_bytes(b"\0")
    with pytest.raises(dw.SceneError, match="binary; allowed is text.*model_converter"):
        dw.read_cameras(tmp_path)


OF_TRANSFORMS = {
    "fisheye": ({"camera_model": "OPENCV_FISHEYE"}, ("frame 'images/0001.png'", "OPENCV_FISHEYE is not known")),
    "k3": ({"k3": 0.1}, ("k3 = 0.1", "allowed is 0")),
    "no frames": ({"frames": []}, ("frames is missing or empty",)),
    "no angle": ({"camera_angle_x": None}, ("fl_x is missing",)),
    "wide": ({"camera_angle_x": 4}, ("camera_angle_x = 4", "between 0 and pi")),
    "text": ({"fl_x": "70"}, ("fl_x = '70'", "a number")),
    "no size": ({"w": None}, ("w = None", "whole numbers")),
    "half": ({"h": 60.5}, ("h = 60.5", "whole numbers")),
    "pose": ({"frames": [frame(transform_matrix=[[1, 2], [3, 4]])]}, ("no matrix of 4 x 4",)),
    "scaled": ({"frames": [frame(transform_matrix=np.diag([2.0, 2, 2, 1]).tolist())]}, ("orthonormal", "0001")),
    "twice": ({"frames": [frame(), frame()]}, ("would both be the camera 'images_0001'",)),
}


@pytest.mark.parametrize("case", OF_TRANSFORMS)
def test_what_is_wrong_with_transforms_is_a_sentence(tmp_path, case):
    keys, parts = OF_TRANSFORMS[case]
    with pytest.raises(dw.SceneError) as error:
        dw.read_cameras(written(tmp_path, **keys))
    assert all(part in str(error.value) for part in ("transforms.json", *parts)), str(error.value)


def test_broken_json_is_a_sentence(tmp_path):
    (tmp_path / "transforms.json").write_text('{"frames": [')
    with pytest.raises(dw.SceneError, match="line 1, column 13: broken JSON"):
        dw.read_cameras(tmp_path)
