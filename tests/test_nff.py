"""NFF files: what becomes of each line, what is said of what is left out, and what is refused."""

import jax
import numpy as np
import pytest
from scene_reader import reader

import diffwhitted as dw
from fitting.command_line import main

VIEW = "v\nfrom 0 -5 1\nat 0 0 0.5\nup 0 0 1\nangle 40\nhither 0\nresolution 16 12\n"
EVERYTHING = f"""# A comment
{VIEW}
b 0.1 0.2 0.3   # the sky
l 3 -4 5
l -3 -4 5 0.5 0.25 0.125
f 1 0.5 0.25 0.8 0.1 20 0 0
s 0 0 1 0.5
s 1 0 1 0.25
p 4
-4 -4 0
4 -4 0
4 4 0
-4 4 0
f 1 1 1 0.1 0.2 90 0.7 1.5
s -1 0 0.5 0.5
pp 3
0 2 0 0 0 1
1 2 0 0 0.6 0.8
0 3 0 0 0 2
c
-2 1 0 0.3
-2 1 1 0.3
c
2 1 0 0.3
2 1 1 0
f 1 0.5 0.25 0.8 0.1 20 0 0
s 0 1 1 0.125
p 3
0 0 2
1 0 2
0 1 2
"""


@pytest.fixture
def read(tmp_path):
    """The scene of a text, and the notes on it."""
    return reader(tmp_path / "scene.nff")


def test_each_line_becomes_what_it_says(read):
    scene, notes = read(EVERYTHING)
    assert notes == []
    assert [(thing.name, thing.material) for thing in scene.objects] == [
        ("spheres_1", "fill_1"), ("polygons_1", "fill_1"), ("spheres_2", "fill_2"), ("patches_2", "fill_2"),
        ("cylinder_1", "fill_2"), ("cone_2", "fill_2"),
    ]  # fmt: skip
    balls, polygons, glass, patches, tube, cone = scene.objects
    np.testing.assert_array_equal(balls.centres, [[0, 0, 1], [1, 0, 1], [0, 1, 1]])
    np.testing.assert_array_equal(balls.radii, [0.5, 0.25, 0.125])
    assert len(polygons.faces) == 2 + 1 and polygons.shading == "flat"
    np.testing.assert_array_equal(glass.radii, [0.5])
    assert patches.shading == "phong"
    np.testing.assert_allclose(patches.normals, [[0, 0, 1], [0, 0.6, 0.8], [0, 0, 2]], rtol=1e-6)
    assert float(tube.radius) == np.float32(0.3) and not tube.capped and not cone.capped
    assert (float(cone.base_radius), float(cone.top_radius)) == (np.float32(0.3), 0.0)
    # Materials: colours times Kd, white Ks for highlight and mirror.
    paint, clear = scene.materials["fill_1"], scene.materials["fill_2"]
    np.testing.assert_allclose(paint.k_d, [0.8, 0.4, 0.2], rtol=1e-6)
    np.testing.assert_array_equal(paint.k_a, paint.k_d)
    assert (float(paint.k_h), float(paint.k_s), float(paint.k_t)) == (np.float32(0.1), np.float32(0.1), 0.0)
    assert float(paint.phong_exponent) == 20 and float(paint.refractive_index) == 1
    assert (float(clear.k_t), float(clear.refractive_index)) == (np.float32(0.7), 1.5)
    # Two lights: sqrt(2) / 4 for that without a colour, and for the ambient light.
    np.testing.assert_allclose(scene.lights[0].colour, np.sqrt(2) / 4, rtol=1e-6)
    np.testing.assert_array_equal(scene.lights[1].colour, [0.5, 0.25, 0.125])
    np.testing.assert_allclose(scene.ambient, np.sqrt(2) / 4, rtol=1e-6)
    np.testing.assert_allclose(scene.background.colour, [0.1, 0.2, 0.3], rtol=1e-6)


def test_the_angle_spans_the_middles_of_the_first_and_last_row(read):
    camera = read(EVERYTHING)[0].cameras["main"]
    assert (camera.width, camera.height) == (16, 12)
    top, bottom = (camera.rays(np.asarray([8.0]), np.asarray([row])).direction.stacked()[0] for row in (0.5, 11.5))
    assert np.degrees(np.arccos(float(top @ bottom))) == pytest.approx(40, abs=1e-3)


def test_what_was_written_as_nff_is_the_scene(read):
    """A small flake, by hand in NFF, against the one that is made by name."""
    balls = dw.standard_scene("balls", 1)
    flake = balls.objects[0]
    lines = ["v", "from 2.1 1.3 1.7", "at 0 0 0", "up 0 0 1", "angle 45", "hither 0", "resolution 512 512"]
    lines += ["b 0.078 0.361 0.753", "l 4 3 2", "l 1 -4 4", "l -3 1 5", "f 1 .75 .33 .8 0 50 0 0", "p 4"]
    lines += ["12 12 -.5", "-12 12 -.5", "-12 -12 -.5", "12 -12 -.5", "f 1 .9 .7 .5 .5 3.0827 0 0"]
    for (x, y, z), radius in zip(np.asarray(flake.centres).tolist(), np.asarray(flake.radii).tolist(), strict=True):
        lines.append(f"s {x!r} {y!r} {z!r} {radius!r}")
    scene = read("\n".join(lines))[0]
    np.testing.assert_array_equal(scene.objects[1].centres, flake.centres)
    for mine, theirs in (
        (scene.cameras["main"], balls.cameras["main"]),
        (scene.materials["fill_1"].values["k_d"], balls.materials["floor"].values["k_d"]),
        (scene.materials["fill_2"].phong_exponent, balls.materials["flake"].phong_exponent),
        ([light.colour for light in scene.lights], [light.colour for light in balls.lights]),
        (scene.ambient, balls.ambient),
    ):
        for one, other in zip(jax.tree.leaves(mine), jax.tree.leaves(theirs), strict=True):
            np.testing.assert_allclose(one, other, rtol=2e-5)


def test_render_and_convert_take_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.nff").write_text(EVERYTHING)
    assert main(["convert", "a.nff", "a.toml"]) == 0
    again = dw.load_scene("a.toml")
    for one, other in zip(jax.tree.leaves(dw.load_scene("a.nff")), jax.tree.leaves(again), strict=True):
        np.testing.assert_array_equal(np.asarray(one), np.asarray(other))
    (tmp_path / "b.nff").write_text(f"{VIEW}l 3 -4 5\nf 1 .5 .2 .8 0 9 0 0\ns 0 0 .5 1\n")
    assert main(["render", "b.nff", "-o", "b.exr", "--width", "8"]) == 0
    assert "8 x 6 pixels" in capsys.readouterr().out
    assert dw.read_image("b.exr").pixels[3, 4, 0] > 0.1


def test_what_cannot_be_said_is_told_once(read):
    text = EVERYTHING.replace("hither 0", "hither 1") + (
        "s 0 0 9 0\ns 0 0 9 -0.5\ns 0 0 8 -0.5\nc\n0 0 0 1\n0 0 0 2\np 3\n0 0 0\n1 1 1\n2 2 2\n"
        "pp 3\n0 0 7 0 0 0\n1 0 7 0 0 1\n0 1 7 0 0 1\n"
        f"f 1 1 1 0 0 9 0.5 0.9\n{VIEW}"
    )
    notes = read(text)[1]
    for said in (
        "line 2: hither of the view is left out",
        "a sphere of radius 0 is left out",
        "a radius below 0, which means a surface seen from within, is taken for one above 0 (2 times)",
        "a cone without a length or a radius is left out",
        "a polygon without an area is left out",
        "a patch with a normal 0 0 0 is taken for a polygon",
        "index 0.9 of a material is below 1, and is taken for 1",
        "a second view v takes the place of the first",
    ):
        assert sum(said in note for note in notes) == 1, (said, notes)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "there is nothing in it to be seen"),
        (VIEW, "there is nothing in it to be seen"),
        ("s 0 0 0 1\n", "line 1: a sphere before the first material"),
        ("f 1 1 1 1 0 0 0 0\ns 0 0 0\n", "line 2: s has 3 numbers; allowed is 4"),
        ("f 1 1 1 1 0 0 0\n", "line 1: f has 7 numbers; allowed is 8"),
        ("f 1 1 1 1 0 0 0 0\ns 0 nan 0 1\n", "line 2: 'nan' is no number"),
        ("f 1 1 1 1 0 0 0 0\ns 0 1e300 0 1\n", "line 2: '1e300' is no number"),
        ("f 1 1 -1 1 0 0 0 0\ns 0 1 0 1\n", "line 1: f: k_a = "),
        ("f 1 1 1 1 0 0 0 0\np 1000000000\n0 0 0\n", "line 2: p 1000000000; allowed is a whole number of corners"),
        ("f 1 1 1 1 0 0 0 0\np -3\n", "line 2: p -3"),
        ("f 1 1 1 1 0 0 0 0\np 4\n0 0 0\n1 0 0\n", "line 2: the file ends after 2 of 4 lines"),
        ("f 1 1 1 1 0 0 0 0\npp 3\n0 0 0\n", "line 3: 3 numbers; allowed is 6, for pp of line 2"),
        ("f 1 1 1 1 0 0 0 0\nc 1\n", "line 2: c stands alone on its line"),
        ("f 1 1 1 1 0 0 0 0\n\n# no\nsphere 1 2 3 4\n", "line 4: a line that begins with 'sphere'; allowed is v"),
        ("l 0 0\n", "line 1: l has 2 numbers; allowed is 3 or 6"),
        ("l 0 0 0 1 1 -1\n", "line 1: the light's colour"),
        ("b 1 1 -1\n", "line 1: b: background = "),
        (VIEW.replace("at 0 0 0.5\n", ""), "line 1: the view v has no at"),
        (VIEW.replace("at 0 0 0.5\n", "at 0 0 0.5\nat 0 0 1\n"), "line 4: at is stated twice"),
        (VIEW.replace("angle 40", "angle 180"), "line 1: angle = 180 of the view"),
        (VIEW.replace("16 12", "16 0"), "line 1: resolution 16 0"),
        (VIEW.replace("16 12", "1e9 1e9"), "line 1: resolution 1e+09 1e+09"),
        (VIEW.replace("up 0 0 1", "up 0 5 -0.5"), "line 1: the view v: up = "),
        ("v 1\n", "line 1: v stands alone on its line"),
        (b"f 1 1 1 1 0 0 0 0\ns \xff\xfe 1\n", "line 2: this is not text"),
        (b"\x00" * 5000, "line 1: 5,000 bytes long"),
        ("l 1 1 1\n" * 1001, "line 1001: more than 1000 lights"),
    ],
)
def test_a_hostile_file_gets_an_error_with_its_line(read, text, said):
    with pytest.raises(dw.SceneError) as error:
        read(text)
    assert "scene.nff: " in str(error.value) and said in str(error.value)
