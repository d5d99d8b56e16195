"""`diffwhitted animate`: keyframes, one program, files, and what goes on after an interruption."""

import sys

import numpy as np
import pytest
from PIL import Image

import diffwhitted as dw
from diffwhitted.rendering._frames import Frames
from fitting.command_line import main
from fitting.command_line._between import Between
from fitting.command_line._film_file import Numbered
from fitting.command_line._keyframes import courses, scene_at, times

SCENE = """
[[camera]]
look_from = [0, 1, 4]
look_at = [0, 0, 0]
vfov_deg = 40
width = 12
height = 9

[[light]]
name = "key"
type = "point"
position = [2, 4, 3]
colour = [0.8, 0.8, 0.8]

[[material]]
name = "paint"
k_a = 0.2
k_d = [0.6, 0.3, 0.2]

[[object]]
name = "ball"
type = "sphere"
centre = [0, 0, 0]
radius = 0.9
material = "paint"
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


def animate(*words) -> int:
    return main(["animate", "scene.toml", "--footprint", "0", *words])


def course(text, between=Between.linear, scene=SCENE):
    return courses(dw.parse_scene(scene), "main", [text], between)[0]


def test_numbers_go_through_their_keyframes():
    line = course("paint.k_a=0:1:0.5")
    assert [line.at(t)[0] for t in (0, 0.25, 0.5, 0.75, 1)] == [0, 0.5, 1, 0.75, 0.5]
    smooth = course("paint.k_a=0:1", Between.smooth)
    assert [smooth.at(t)[0] for t in (0, 0.25, 0.5, 1)] == pytest.approx([0, 3 / 16 - 2 / 64, 0.5, 1])
    several = course("light.key.position=[0,1,2]:[2,1,0]")
    np.testing.assert_allclose(several.at(0.25), (0.5, 1, 1.5))
    assert course("paint.k_a=0.7").at(0.3) == [0.7]


def test_an_orbit_turns_about_what_the_camera_looks_at():
    orbit = course("camera.main.look_from=orbit:360")
    np.testing.assert_allclose([orbit.at(t) for t in (0, 0.25, 0.5)], [(0, 1, 4), (4, 1, 0), (0, 1, -4)], atol=1e-12)
    # A film that ends where it begins does not show that twice.
    np.testing.assert_allclose(times([orbit], 4), (0, 0.25, 0.5, 0.75))
    np.testing.assert_allclose(times([course("paint.k_a=0:1")], 5), (0, 0.25, 0.5, 0.75, 1))


def test_frames_are_those_of_render_by_one_program():
    """Also where a coefficient begins at 0, whose effect the first frame does not need."""
    scene = dw.parse_scene(SCENE)
    found = courses(scene, "main", ["paint.k_s=0:0.6", "camera.main.look_from=[0,1,4]:[1,1,4]"], Between.linear)
    frames = Frames("main", tuple(one.name for one in found), footprint=0)
    at = times(found, 4)
    pictures = dict(frames.traced(lambda number: scene_at(scene, found, at[number]), range(4)))
    assert len(frames.plans) == 1 and list(pictures) == [0, 1, 2, 3]
    for number in (0, 3):
        one = scene_at(scene, found, at[number])
        np.testing.assert_allclose(pictures[number], dw.render(one, one.cameras["main"]), atol=1e-6)


def test_a_frame_that_calls_for_more_gets_another_plan():
    scene = dw.parse_scene(SCENE)
    frames = Frames("main", (), footprint=0)

    def scene_of(number):
        return dw.replace_parameter(scene, "paint.k_s", 0.5 * (number > 1))

    pictures = dict(frames.traced(scene_of, range(3)))
    assert len(frames.plans) == 2
    np.testing.assert_allclose(pictures[2], dw.render(scene_of(2), scene.cameras["main"]), atol=1e-6)


def test_numbered_pictures_go_on_where_they_were_left(place, capsys, monkeypatch):
    words = ("--set", "paint.k_a=0:1", "--frames", "5", "-o", "frames/%03d.exr")
    added, add = [], Numbered.add

    def interrupted(self, number, pixels):
        if number == 3 and not added:
            raise KeyboardInterrupt
        add(self, number, pixels)

    monkeypatch.setattr(Numbered, "add", interrupted)
    assert animate(*words) == 130
    before = {path.name: path.stat().st_mtime_ns for path in (place / "frames").glob("*.exr")}
    assert sorted(before) == ["000.exr", "001.exr", "002.exr"]
    added.append("on")
    assert animate(*words) == 0 and "3 of them kept" in capsys.readouterr().out
    after = {path.name: path.stat().st_mtime_ns for path in (place / "frames").glob("*.exr")}
    assert len(after) == 5 and all(after[name] == time for name, time in before.items())
    # Another film does not take them for its own.
    assert animate("--set", "paint.k_a=0:0.5", *words[2:]) == 0 and "kept" not in capsys.readouterr().out
    last = dw.read_image(place / "frames" / "004.exr").pixels
    scene = dw.replace_parameter(dw.load_scene("scene.toml"), "paint.k_a", 0.5)
    np.testing.assert_allclose(last, dw.render(scene, scene.cameras["main"]), atol=1e-6)


def test_a_gif_has_its_frames(place, capsys):
    assert animate("--set", "camera.main.look_from=orbit:360", "--frames", "3", "--fps", "10", "-o", "film.gif") == 0
    assert "3 frames of 12 x 9 pixels" in capsys.readouterr().out
    with Image.open(place / "film.gif") as film:
        assert (film.n_frames, film.size, film.info["duration"]) == (3, (12, 9), 100)
    assert not list(place.glob(".film*"))


def test_a_video_is_what_ffmpeg_is_given(place, monkeypatch):
    """By a stand-in that writes down what it gets."""
    fake = place / "ffmpeg"
    fake.write_text(
        f"#!{sys.executable}\nimport sys\nopen(sys.argv[-1], 'wb').write(sys.stdin.buffer.read())\n", encoding="utf-8"
    )
    fake.chmod(0o755)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", str(place))
    assert animate("--set", "paint.k_a=0:1", "--frames", "4", "-o", "film.mp4") == 0
    codes = np.frombuffer((place / "film.mp4").read_bytes(), np.uint8).reshape(4, 9, 12, 3)
    assert (codes[1:].astype(int).sum(axis=(1, 2, 3)) > codes[:-1].astype(int).sum(axis=(1, 2, 3))).all()


@pytest.mark.parametrize(
    "words, message",
    [
        (["--set", "paint.kd=0:1", "-o", "a.gif"], "paint.kd"),
        (["--set", "paint.k_a", "-o", "a.gif"], "--set paint.k_a: allowed is NAME=V0:V1"),
        (["--set", "paint.k_a=0:red", "-o", "a.gif"], "'red' is not a number"),
        (["--set", "paint.k_a=0:1,2", "-o", "a.gif"], "'1,2' has 2 numbers, and paint.k_a has 1"),
        (["--set", "paint.k_a=0:-1", "-o", "a.gif"], "allowed is >= 0"),
        (["--set", "paint.k_a=orbit:90", "-o", "a.gif"], "allowed is NAME=orbit:DEGREES, of a place"),
        (["--set", "paint.k_a=0:1", "--set", "paint.k_a=1:0", "-o", "a.gif"], "it is stated twice"),
        (["--set", "paint.k_a=0:1", "-o", "a.png"], "one file of this kind holds no film"),
        (["--set", "paint.k_a=0:1", "-o", "a%d_%d.png"], "allowed is one number in the name of the file"),
        (["--set", "paint.k_a=0:1", "-o", "a%04d.bmp"], "cannot write the extension '.bmp'"),
        (["--set", "paint.k_a=0:1", "-o", "film.mp4"], "it takes ffmpeg, which is not here"),
    ],
)
def test_what_is_no_film_is_named(place, capsys, monkeypatch, words, message):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", "")
    assert animate("--frames", "3", *words) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1
    assert not list(place.glob("a*"))
