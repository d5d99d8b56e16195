"""Scene files: what each key becomes, the same bits after a round trip, and the JSON Schema."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import diffwhitted as dw
from diffwhitted._errors import SceneError
from diffwhitted.formats import (
    SceneFormat,
    including_format,
    load_scene,
    parse_scene,
    save_scene,
    scene_schema,
    scene_text,
)
from diffwhitted.scene import (
    COEFFICIENTS,
    Camera,
    Checker,
    ConstantBackground,
    DirectionalLight,
    GradientBackground,
    Material,
    Plane,
    PointLight,
    Polygon,
    Scene,
    Sphere,
)

FILE = Path(__file__).with_name("every_key.toml").read_text()


def assert_same_scene(one: Scene, other: Scene):
    """The same records, names and settings, and the same bits in every array."""
    assert jax.tree.structure(one) == jax.tree.structure(other)
    for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True):
        assert (a.dtype, a.shape, np.asarray(a).tobytes()) == (b.dtype, b.shape, np.asarray(b).tobytes())


def changed(old: str, new: str) -> str:
    assert old in FILE
    return FILE.replace(old, new, 1)


# Reading


def test_every_key_arrives_in_its_record():
    scene = parse_scene(FILE)
    ball, floor, sheet, flag = scene.objects
    glass, camera, (lamp, sun) = scene.materials["glass"], scene.cameras["main"], scene.lights
    assert (scene.max_depth, scene.shadows, scene.total_internal_reflection) == (5, "opaque", "full") and (
        scene.footprint,
        float(scene.cutoff),
    ) == (2, pytest.approx(0.001))
    assert (ball.name, ball.material, float(ball.radius)) == ("ball", "glass", 1.0)
    assert (float(floor.offset), sheet.vertices.shape, flag.vertices.shape) == (-1.0, (5, 3), (3, 3))
    assert (glass.highlight, glass.k_a_texture, glass.k_d_texture) == ("reflected", None, "tiles")
    assert glass.k_d.tolist() == pytest.approx([0.12, 0.13, 0.14]) and glass.k_s.shape == ()
    assert (camera.width, camera.height, float(camera.vfov_deg)) == (320, 240, pytest.approx(61.9275))
    assert lamp.position.tolist() == [3, 5, 4] and sun.direction.tolist() == [0, 1, 0] and lamp.attenuation is None
    assert (scene.textures["tiles"].axes, float(scene.textures["tiles"].size)) == ("xz", 1.0)
    assert scene.background.colour.tolist() == pytest.approx([0.4, 0.6, 0.9])


def test_keys_that_few_files_state_arrive_too():
    fading = changed("colour = [0.9, 0.9, 0.9]", "colour = [0.9, 0.9, 0.9]\nattenuation = [1, 2, 3]")
    scene = parse_scene(
        fading.replace("k_d_texture", "k_a_texture").replace(
            "[0.4, 0.6, 0.9]", "{ gradient = [[0, 0, 0], [0, 0.5, 1]] }"
        )
    )
    glass = scene.materials["glass"]
    assert scene.lights[0].attenuation.tolist() == [1, 2, 3]
    assert (glass.k_a_texture, glass.k_d_texture) == ("tiles", None)
    assert (scene.background.bottom.tolist(), scene.background.top.tolist()) == ([0, 0, 0], [0, 0.5, 1])


def test_keys_that_are_left_out_have_their_stated_defaults():
    scene = parse_scene("""
        [[camera]]
        look_from = [0, 0, 5]
        look_at = [0, 0, 0]
        vfov_deg = 60
        width = 4
        height = 3
        [[texture]]
        name = "cells"
        type = "checker"
        colours = [[0, 0, 0], [1, 1, 1]]
        [[material]]
        name = "plain"
    """)
    plain = scene.materials["plain"]
    assert scene.background.colour.tolist() == [0, 0, 0] and scene.ambient.tolist() == [1, 1, 1]
    assert (scene.max_depth, scene.total_internal_reflection, scene.shadows) == (5, "full", "opaque")
    assert scene.cameras["main"].up.tolist() == [0, 1, 0]
    assert (scene.textures["cells"].axes, float(scene.textures["cells"].size)) == ("xyz", 1.0)
    assert plain.highlight == "halfway" and plain.k_h is None
    assert all(float(getattr(plain, row.name)) == row.default for row in COEFFICIENTS if row.default is not None)


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + FILE.replace("\n", "\r\n").encode())
    assert_same_scene(load_scene(path), parse_scene(FILE))


# Round trip


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize(
    "old, new",
    [
        ("max_depth = 5", "max_depth = 12"),
        ("background = [0.4, 0.6, 0.9]", "background = { gradient = [[0.1, 0.2, 0.3], [1, 1, 1]] }"),
        ("colour = [0.9, 0.9, 0.9]", "colour = [0.9, 0.9, 0.9]\nattenuation = [1, 0.1, 0.01]"),
        ("ambient = [1.0, 1.0, 1.0]", "ambient = { sky = [1, 1, 0.3], ground = [0, 0.1, 0] }"),
        ("ambient = [1.0, 1.0, 1.0]", "ambient = { sky = [1, 1, 0.3], ground = [0, 0.1, 0], up = [0, 2, 1] }"),
        ("cutoff = 0.001", "cutoff = 0.001\ndistance_fade = [1, -0.01]"),
        ("k_h = 0.3\n", ""),
        ("k_h = 0.3", "k_h = [0.3, 0.3, 0.3]"),
        ("k_d_texture", "k_a_texture"),
        ('shadows = "opaque"', 'shadows = "tinted"'),
        ('"full"', '"whitted"'),
        ('name = "main"', 'name = "from \\"above\\" \\n é"'),
        ("radius = 1", "radius = 1e-40"),
        ("radius = 1", "radius = 0.30000001192092896"),
        ("offset = -1", "offset = -0.0"),
        ("offset = -1", "offset = 3.4028234e38"),
        ("offset = -1", "offset = 12345678.9"),
    ],
)
def test_a_scene_saved_and_loaded_has_the_same_bits(tmp_path, old, new, precision):
    with jax.enable_x64(precision == "float64"):
        scene = parse_scene(changed(old, new), precision=precision)
        save_scene(scene, tmp_path / "scene.toml")
        assert_same_scene(scene, load_scene(tmp_path / "scene.toml", precision=precision))


NUMBERS = st.floats(width=32, allow_nan=False, allow_infinity=False)
POSITIVE = st.floats(0, width=32, allow_nan=False, allow_infinity=False)
NAMES = st.text(st.characters(codec="utf-8"), min_size=1, max_size=8)


def listed(numbers):
    return st.lists(numbers, min_size=3, max_size=3).map(lambda values: np.array(values, np.float32))


def one_or_three(numbers):
    return numbers.map(np.float32) | listed(numbers)


@st.composite
def scenes(draw) -> Scene:
    names = draw(st.lists(NAMES, min_size=1, max_size=3, unique=True))
    texture = draw(NAMES)

    def material(k_h, textured):
        allowed = {row.name: (np.float32(row.lowest), np.float32(row.highest)) for row in COEFFICIENTS}
        shown = {
            row.name: draw(one_or_three(POSITIVE) if row.coloured else POSITIVE.map(np.float32))
            for row in COEFFICIENTS
            if row.name != "height_scale"  # needs a texture of heights: see `test_wrinkles`
        }
        values = {name: np.clip(value, *allowed[name]) for name, value in shown.items()}
        return Material(
            **values | ({} if k_h else {"k_h": None}),
            k_d_texture=texture if textured else None,
            highlight=draw(st.sampled_from(["halfway", "reflected", "off"])),
        )

    sphere = Sphere(
        "ball", draw(listed(NUMBERS)), np.maximum(draw(POSITIVE.map(np.float32)), np.float32(1e-45)), names[0]
    )
    colours = draw(st.lists(listed(POSITIVE), min_size=6, max_size=6))
    return Scene(
        objects=[sphere],
        materials={name: material(draw(st.booleans()), draw(st.booleans())) for name in names},
        lights=[PointLight(draw(listed(NUMBERS)), colours[0]), DirectionalLight(np.float32([0, 1, 0]), colours[1])],
        textures={texture: Checker(np.stack(colours[2:4]), np.float32(0.1))},
        ambient=colours[4],
        background=draw(st.sampled_from([ConstantBackground(colours[5]), GradientBackground(colours[4], colours[5])])),
        cameras={names[0]: Camera(np.float32([0, 0, 5]), np.float32([0, 0, 0.1]), np.float32(33.3), 4, 3)},
    )


@settings(max_examples=25, deadline=None)
@pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
@given(scenes())
def test_any_scene_has_the_same_bits_after_its_text(scene):
    assert_same_scene(scene, parse_scene(scene_text(scene)))


@pytest.mark.parametrize(
    "precision, text",
    [
        ("float32", "0.1"),
        ("float64", "0.1"),
        ("float32", "16777.217"),
        ("float32", "1e-45"),
        ("float64", "0.30000000000000004"),
    ],
)
def test_a_number_is_written_as_short_as_its_precision_allows(precision, text):
    with jax.enable_x64(precision == "float64"):
        scene = parse_scene(changed("radius = 1", f"radius = {text}"), precision=precision)
        assert f"radius = {text}\n" in scene_text(scene)


def test_saved_text_has_the_order_of_its_file_and_short_numbers():
    text = scene_text(parse_scene(FILE))
    tables = [line for line in text.splitlines() if line.startswith("[")]
    assert tables == [line for line in FILE.splitlines() if line.startswith("[")]
    assert "vfov_deg = 61.9275\n" in text and "k_d = [0.12, 0.13, 0.14]\n" in text and "k_a = 0.012\n" in text
    assert tomllib.loads(text) == tomllib.loads(FILE)


def test_a_scene_that_could_not_be_read_back_is_not_written(tmp_path):
    path = tmp_path / "kept.toml"
    path.write_text("kept")
    scene = parse_scene(FILE)
    for radius, words in ((np.nan, "nan"), (-1.0, "radius = -1; allowed is > 0")):
        broken = jax.tree.map(lambda a: a, scene)
        ball = Sphere("ball", [0, 0, 0], 1.0, "glass")
        object.__setattr__(ball, "radius", jnp.float32(radius))
        object.__setattr__(broken, "objects", (ball,))
        with pytest.raises(SceneError) as caught:
            save_scene(broken, path)
        assert 'object "ball" (1st [[object]])' in str(caught.value) and words in str(caught.value)
    assert path.read_text() == "kept" and list(tmp_path.iterdir()) == [path]


def test_saving_replaces_whole_and_leaves_nothing_beside(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("old")
    save_scene(parse_scene(FILE), path)
    assert path.read_text() == scene_text(parse_scene(FILE)) and list(tmp_path.iterdir()) == [path]


def test_a_place_that_cannot_be_written_is_named_and_nothing_is_left_there(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    for path, words in ((tmp_path / "missing" / "scene.toml", "make the folder first"), (folder, "cannot be written")):
        with pytest.raises(SceneError) as caught:
            save_scene(parse_scene(FILE), path)
        assert str(caught.value).startswith(f"{path}: ") and words in str(caught.value)
    assert list(tmp_path.iterdir()) == [folder] and list(folder.iterdir()) == []


# The JSON Schema


def test_the_schema_is_plain_json_that_holds_every_table_and_coefficient():
    schema = scene_schema()
    assert json.loads(json.dumps(schema, allow_nan=False)) == schema
    assert list(schema["properties"]) == [
        "scene",
        "camera",
        "light",
        "texture",
        "material",
        "object",
        "shot",
        "cameras",
    ]
    assert schema["additionalProperties"] is False and "$schema" in schema
    material = schema["$defs"]["MaterialEntry"]["properties"]
    for row in COEFFICIENTS:
        entry = material[row.name]
        kinds = entry["oneOf"] if row.coloured else [entry]
        assert kinds[0]["type"] == "number" and kinds[0]["minimum"] == row.lowest
        assert entry.get("default") == row.default and row.meaning in entry["description"]
        assert row.source in entry["description"] and row.symbol in entry["description"]
        assert len(kinds) == (2 if row.coloured else 1)


def test_every_key_is_described():
    schema = scene_schema()
    entries = [definition["properties"] for definition in schema["$defs"].values()] + [schema["properties"]]
    assert [
        key for entry in entries for key, field in entry.items() if key != "type" and "description" not in field
    ] == []


def test_importing_starts_no_backend():
    code = "import diffwhitted.formats; from jax._src import xla_bridge; assert not xla_bridge._backends"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_records_made_in_python_are_written_like_those_of_a_file():
    scene = Scene(
        objects=[
            Sphere("ball", [0, 0, 0], 1, "red"),
            Plane("floor", [0, 1, 0], -1, "red"),
            Polygon("flag", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "red"),
        ],
        materials={"red": Material(k_d=[0.8, 0.1, 0.1])},
        lights=[PointLight([1, 2, 3], 0.5, attenuation=[1, 0, 0.1])],
    )
    written = tomllib.loads(scene_text(scene))
    assert [entry["type"] for entry in written["object"]] == ["sphere", "plane", "triangle"]
    assert written["light"] == [
        {"type": "point", "position": [1, 2, 3], "colour": [0.5, 0.5, 0.5], "attenuation": [1, 0, 0.1]}
    ]
    assert "k_h" not in written["material"][0] and "camera" not in written and "texture" not in written
    assert_same_scene(scene, parse_scene(scene_text(scene)))


def test_the_suffix_says_the_format(tmp_path):
    """A format that is registered reads and writes the files of its suffix; one that cannot write says so."""
    scene = parse_scene("[scene]\nambient = [0.5, 0.25, 1.0]\n")

    def words(data: bytes, source: str, precision) -> dw.Scene:
        return dw.Scene(objects=[], materials={}, ambient=[float(n) for n in data.split()], precision=precision)

    def numbers(scene: dw.Scene, source: str) -> bytes:
        return " ".join(f"{float(n)}" for n in scene.ambient).encode()

    for write in (numbers, None):
        with including_format(SceneFormat("words", (".words",), words, write)):
            if write is None:
                with pytest.raises(SceneError, match=r"scenes in words are read, not written; write it as \.toml"):
                    save_scene(scene, tmp_path / "scene.WORDS")
                continue
            save_scene(scene, tmp_path / "scene.words")
            assert (tmp_path / "scene.words").read_text() == "0.5 0.25 1.0"
            assert load_scene(tmp_path / "scene.words").ambient.tolist() == [0.5, 0.25, 1.0]
    with pytest.raises(SceneError, match="broken TOML"):
        load_scene(tmp_path / "scene.words")
