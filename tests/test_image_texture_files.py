"""Image textures in scene files and other programs: round trip, broken pictures, names of texels, POV-Ray."""

import json
import shutil
import struct
import zlib
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from benchmarks import _povray
from diffwhitted.scene import maps

TEXELS = np.round(np.random.default_rng(5).random((4, 6, 3)) * 65535).astype(np.float32) / 65535
TEXT = """
[[camera]]
look_from = [0.5, 0.5, 5]
look_at = [0.5, 0.5, 0]
vfov_deg = 30
width = 24
height = 18
[[texture]]
name = "wall"
type = "image"
file = "pictures/wall.exr"
wrap = "mirror"
mapping = "planar"
edge_u = [1, 0, 0.25]
[[material]]
name = "paint"
k_a = 1
k_d = 0
k_a_texture = "wall"
[[object]]
name = "wall"
type = "plane"
normal = [0, 0, 1]
offset = 0
material = "paint"
"""


@pytest.fixture
def folder(tmp_path) -> Path:
    (tmp_path / "pictures").mkdir()
    dw.write_image(tmp_path / "pictures" / "wall.exr", TEXELS)
    (tmp_path / "scene.toml").write_text(TEXT)
    return tmp_path


def test_a_scene_file_names_its_picture_from_where_it_is(folder, monkeypatch):
    """Read from another folder, and saved to a third."""
    monkeypatch.chdir(folder.parent)
    scene = dw.load_scene(folder / "scene.toml")
    np.testing.assert_allclose(scene.textures["wall"].texels, TEXELS, atol=5e-4)
    assert scene.textures["wall"].wrap == "mirror" and scene.textures["wall"].encoding is None
    (folder / "elsewhere").mkdir()
    dw.save_scene(scene, folder / "elsewhere" / "scene.toml")
    saved = (folder / "elsewhere" / "scene.toml").read_text()
    assert 'file = "../pictures/wall.exr"' in saved
    again = dw.load_scene(folder / "elsewhere" / "scene.toml")
    for key in ("texels", "origin", "edge_u", "edge_v"):
        assert np.array_equal(getattr(again.textures["wall"], key), getattr(scene.textures["wall"], key))


def test_the_encoding_is_that_of_the_scene_file(folder):
    dw.write_image(folder / "pictures" / "wall.png", TEXELS)
    texts = [TEXT.replace("wall.exr", f'wall.png"\nencoding = "{name}') for name in ("srgb", "linear")]
    srgb, linear = (dw.parse_scene(text, folder=folder).textures["wall"].texels for text in texts)
    np.testing.assert_allclose(srgb, TEXELS, atol=5e-3)
    assert abs(np.asarray(linear) - TEXELS).max() > 0.1


def png(width: int, height: int) -> bytes:
    """The beginning of a PNG of any size, without its pixels."""
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))


def picture_with(folder: Path, value: float) -> None:
    pixels = TEXELS.copy()
    pixels[2, 3, 1] = value
    dw.write_image(folder / "pictures" / "wall.exr", pixels)


def into_folder(folder: Path) -> None:
    (folder / "pictures" / "wall.exr").unlink()
    (folder / "pictures" / "wall.exr").mkdir()


BROKEN = {
    "missing": (lambda folder: (folder / "pictures" / "wall.exr").unlink(), ["wall.exr"]),
    "empty": (lambda folder: (folder / "pictures" / "wall.exr").write_bytes(b""), ["wall.exr"]),
    "huge": (lambda folder: (folder / "pictures" / "wall.exr").write_bytes(png(2**31 - 1, 2**31 - 1)), ["wall.exr"]),
    "a folder": (into_folder, ["wall.exr", "folder"]),
    "NaN": (lambda folder: picture_with(folder, np.nan), ["wall.exr", "row 2, column 3", "nan", "1 of 24"]),
    "infinite": (lambda folder: picture_with(folder, np.inf), ["wall.exr", "row 2, column 3"]),
    "negative": (lambda folder: picture_with(folder, -0.5), ["wall.exr", "row 2, column 3", "-0.5", ">= 0"]),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("fault", BROKEN)
def test_a_picture_that_cannot_be_used_is_named(folder, fault):
    breaks, words = BROKEN[fault]
    breaks(folder)
    with pytest.raises(dw.SceneError) as error:
        dw.load_scene(folder / "scene.toml")
    assert all(word in str(error.value) for word in ["texture 'wall'", *words]) or all(
        word in str(error.value) for word in ['texture "wall"', *words]
    )


@pytest.mark.parametrize(
    ("changed", "into", "words"),
    [
        ('wrap = "mirror"', 'wrap = "round"', ["wrap", "round", "repeat", "clamp", "mirror"]),
        ('mapping = "planar"', 'mapping = "flat"', ["mapping", "flat", "planar", "triplanar"]),
        ("edge_u = [1, 0, 0.25]", "centre = [0, 0, 0]", ["centre", "spherical", "planar", "edge_u"]),
        ("edge_u = [1, 0, 0.25]", "edge_u = [0, 2, 0]", ["edge_v", "edge_u = [0, 2, 0]"]),
        ("edge_u = [1, 0, 0.25]", "edge_u = [0, 0, 0]", ["edge_u", "any vector but zero"]),
        ('mapping = "planar"\nedge_u = [1, 0, 0.25]', "", ["object 'wall'", "plane", "texture 'wall'", '"planar"']),
        ('file = "pictures/wall.exr"', "", ["file"]),
        ('wrap = "mirror"', 'encoding = "sgrb"', ["encoding", "sgrb", "srgb"]),
    ],
)
def test_what_is_not_allowed_is_said(folder, changed, into, words):
    with pytest.raises(dw.SceneError) as error:
        dw.parse_scene(TEXT.replace(changed, into), folder=folder)
    assert all(word in str(error.value) for word in words), error.value


@pytest.mark.parametrize("texels", [np.ones((2, 2)), np.ones((0, 2, 3)), np.ones((2, 2, 4)), "picture", [[["a"] * 3]]])
def test_texels_of_another_shape_are_refused(texels):
    with pytest.raises(dw.SceneError, match=r"\(height, width, 3\)"):
        dw.ImageTexture(texels, mapping="planar")


def test_one_texel_is_a_colour(folder):
    dw.write_image(folder / "pictures" / "wall.exr", np.full((1, 1, 3), 0.25, np.float32))
    scene = dw.load_scene(folder / "scene.toml")
    for footprint in (0, 1):
        picture = dw.render(scene, scene.cameras["main"], footprint=footprint, max_depth=1)
        np.testing.assert_allclose(picture, 0.25, atol=1e-6)


def test_texels_have_one_name(folder, capsys):
    """No unknown of a fit by itself, a line in the list, replaced as a whole."""
    from fitting import FitError, fit
    from fitting.command_line import main

    scene = dw.load_scene(folder / "scene.toml")
    assert [p.name for p in maps(scene)] == ["texture.wall.texels"]
    names = [p.name for p in dw.parameters(scene) if p.family == "texture"]
    assert names == ["texture.wall.origin", "texture.wall.edge_u", "texture.wall.edge_v"]
    new = dw.replace_parameter(scene, "texture.wall.texels", jnp.ones((4, 6, 3)))
    assert float(dw.parameter_value(new, "texture.wall.texels").min()) == 1
    with pytest.raises(dw.SceneError, match="in no file"):
        dw.save_scene(new, folder / "new.toml")
    with pytest.raises(dw.SceneError, match="shape"):
        dw.replace_parameter(scene, "texture.wall.texels", jnp.ones((4, 5, 3)))
    with pytest.raises(FitError, match="fit_texture"):
        fit(scene, np.ones((18, 24, 3)), ["texture.wall.texels"])
    main(["parameters", str(folder / "scene.toml"), "texture.*"])
    assert "4 x 6 texels" in " ".join(capsys.readouterr().out.split())
    main(["parameters", str(folder / "scene.toml"), "--json"])
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["parameters"]}
    assert rows["texture.wall.texels"]["shape"] == [4, 6, 3] and rows["texture.wall.texels"]["unknowns"] == []


@pytest.mark.skipif(shutil.which("povray") is None, reason=_povray.MISSING)
def test_povray_lays_the_picture_on_the_plane_as_we_do(tmp_path):
    """Its image_map fills the unit square of x and y and repeats; half floats resolve 5e-4."""
    dw.write_image(tmp_path / "wall.exr", TEXELS)
    texture = dw.ImageTexture(dw.read_image(tmp_path / "wall.exr").pixels, mapping="planar")
    angle = np.degrees(2 * np.arctan(4 / 3 * np.tan(np.radians(15))))
    (tmp_path / "scene.pov").write_text(
        "#version 3.7; global_settings { assumed_gamma 1 }\n"
        f"camera {{ perspective location <0.5,0.5,-5> look_at <0.5,0.5,0> right 4/3*x angle {angle:.9f} }}\n"
        f'plane {{ <0,0,-1>, 0 pigment {{ image_map {{ exr "{tmp_path}/wall.exr" interpolate 2 }} }}\n'
        "finish { ambient 1 diffuse 0 } }\n"
    )
    scene = dw.Scene(
        objects=[dw.Plane("wall", (0, 0, 1), 0, "paint")],
        materials={"paint": dw.Material(k_d=0, k_h=0, k_a=1, k_a_texture="wall")},
        textures={"wall": texture},
        cameras={"main": dw.Camera((0.5, 0.5, 5), (0.5, 0.5, 0), 30, 64, 48)},
        max_depth=1,
    )
    theirs = _povray.trace(tmp_path / "scene.pov", 64, 48).pixels
    ours = dw.render(scene, scene.cameras["main"])
    np.testing.assert_allclose(ours, theirs, atol=1.5e-3)
    assert np.std(theirs) > 0.1
