"""Scenes as other programs have them: values by hand, and POV-Ray's own picture of what is written for it."""

import base64
import json
import math
import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import unknown_kinds
from leaving_samples import everything

import diffwhitted as dw
from benchmarks import _povray
from diffwhitted import SceneError
from diffwhitted.formats import FORMATS, including_format
from diffwhitted.formats._meshes import ball, checker_coordinates, triangulated

OUT = ("pov", "xml", "gltf", "mtl", "json", "tex", "md")


@pytest.fixture(scope="module")
def truth():
    return dw.load_scene(Path(__file__).parents[1] / "examples" / "three_spheres_truth.toml")


@pytest.fixture
def written(tmp_path):
    """A scene as text in a format, and what was lost."""

    def write(scene, suffix):
        lost = dw.save_scene(scene, tmp_path / f"scene.{suffix}")
        return (tmp_path / f"scene.{suffix}").read_text(encoding="utf-8"), lost

    return write


def test_what_is_only_written_is_not_read(tmp_path):
    for suffix in set(OUT) - {"gltf", "pov", "xml"}:
        with pytest.raises(
            SceneError, match=r"are written, not read; give a scene in \.toml, \.nff, \.pov, \.xml, \.yml, \.yaml"
        ):
            dw.load_scene(tmp_path / f"scene.{suffix}")


def test_toml_loses_nothing(written, truth):
    assert written(truth, "toml")[1] == ()


@pytest.mark.parametrize("suffix", OUT)
def test_what_no_format_knows_is_told(suffix, written):
    """Kinds and coefficients that were registered a moment ago; also in the file itself."""
    with unknown_kinds.known():
        text, lost = written(dw.parse_scene(unknown_kinds.TOML), suffix)
    said = " ".join(lost)
    if suffix in ("json", "tex", "md"):
        assert ("$k_{e}$" if suffix == "tex" else "k_e") in text
    else:
        assert 'k_e of material "paint" is lost' in said
    if suffix in ("pov", "xml", "gltf"):
        assert 'left out: object "plate" (coin)' in said and 'left out: light "tower" (beacon)' in said
    for sentence in lost:
        inside = sentence.partition(": ")[2].replace("|", r"\|")
        plain = text.replace("\\*", "*").replace(r"\"", '"')
        assert inside in plain


def test_a_setting_that_a_format_does_not_know_is_told(monkeypatch):
    """A key that the scene's record takes and that differs from its default, such as one of a later version."""
    from diffwhitted.formats._losses import Losses

    scene, lost = everything(cutoff=0.25), Losses("some")
    lost.unknown_settings(scene, ("ambient", "max_depth"))
    lost.unknown(scene.cameras["main"], ("look_from", "look_at", "vfov_deg", "width", "height"), ("camera", "main"))
    assert list(lost) == ["some: cutoff of the scene is lost", 'some: up of camera "main" is lost']


# POV-Ray


def test_the_text_for_povray_has_the_numbers_of_the_example(written, truth):
    """Those of examples/three_spheres_povray.pov, which was written by hand."""
    text, lost = written(truth, "pov")
    assert lost == ()
    for line in (
        "global_settings { assumed_gamma 1.0 max_trace_level 5 adc_bailout 0 }",
        "background { rgb <0.4,0.6,0.9> }",
        "light_source { <3,5,-4> rgb <0.9,0.9,0.9> }",
        "location <0,0.52,-6>",
        "right <1.33333333333,0,0> sky <0,1,0> look_at <0,0.5,0>",
        "rgbt <0.4,0.4,0.4,0.7> } finish { ambient 0.1 diffuse 1 phong 0.3 phong_size 50 "
        "reflection { rgb <0.2,0.2,0.2> }",
        "rgb <0.4,0.7,0.3> } finish { ambient 0.1 diffuse 1 phong 0.3 phong_size 50 reflection { rgb <0.1,0.1,0.1> }",
        "sphere { <1.2,-0.3,1.5>, 0.7 texture",
        "sphere { <0,0,0>, 1 texture { T_glass } interior { ior 1.5 } }",
        "plane { <0,1,0>, -1 texture",
    ):
        assert line in text
    # In the example the mirror's pigment is its k_d / 0.4, with diffuse 0.4.
    assert "rgb <0.12,0.16,0.2> } finish { ambient 0.25 diffuse 1" in text
    ahead = float(text.partition("direction <0,0,")[2].partition(">")[0])
    assert ahead == pytest.approx(0.833333333333, rel=1e-8)


@pytest.mark.skipif(shutil.which("povray") is None, reason=_povray.MISSING)
@pytest.mark.parametrize(
    "shadows", ["opaque", *(pytest.param(other, marks=pytest.mark.slow) for other in ("tinted", "off"))]
)
def test_povray_renders_the_same_picture(shadows, tmp_path):
    """Layers of coloured coefficients, checkerboards within each other, fading lights, polygons, a sky, opaque shadows
    of glass. The half floats of its file are good to 2.4e-4; a few pixels lie on edges.
    """
    scene = everything(shadows=shadows)
    camera = scene.cameras["main"]
    assert dw.save_scene(scene, tmp_path / "scene.pov") == ()
    theirs = _povray.trace(tmp_path / "scene.pov", camera.width, camera.height).pixels
    ours = np.asarray(dw.render(scene, camera))
    apart = np.abs(ours - theirs).max(axis=-1)
    assert np.median(apart) < 2e-4 and np.quantile(apart, 0.99) < 5e-4
    assert (apart > 0.01).mean() < 2e-3


def test_povray_is_told_of_several_cameras_and_what_it_cannot(written):
    scene = everything(total_internal_reflection="whitted")
    other = dw.Camera([5, 1, 0], [0, 0, 0], 30, 40, 30)
    lights = [dw.PointLight([0, 1, 0], 1, attenuation=[0.5, 0.1, 0.2], name="lamp\n*/")]
    scene = dw.Scene(
        objects=scene.objects, materials=scene.materials, textures=scene.textures, lights=lights,
        cameras={"side": other, **scene.cameras}, total_internal_reflection="whitted",
    )  # fmt: skip
    text, lost = written(scene, "pov")
    assert "#case (1) camera { perspective location <0.3,0.8,-6>" in text
    assert "#case (2) camera { perspective location <5,1,0>" in text
    assert r'// "lamp\\n*/"' in text or r'// "lamp\n*/"' in text
    for words in ("one camera at a time", "a1 = 0.1 is lost", "above 1", "total_internal_reflection"):
        assert any(words in sentence for sentence in lost)


# Materials: MTL and glTF


def test_mtl_by_hand(written, truth):
    text, lost = written(truth, "mtl")
    blocks = {block.split()[0]: dict(line.split(" ", 1) for line in block.splitlines()[1:] if line)
              for block in text.split("newmtl ")[1:]}  # fmt: skip
    assert blocks["glass"] == {
        "Ka": "0.012 0.012 0.012", "Kd": "0.12 0.12 0.12", "Ks": "0.3 0.3 0.3", "Ns": "50", "Ni": "1.5", "d": "0.3",
        "Tf": "0.7 0.7 0.7", "illum": "6",
    }  # fmt: skip
    assert blocks["green"]["Kd"] == "0.4 0.7 0.3" and blocks["green"]["illum"] == "3"
    assert blocks["floor"]["illum"] == "1" and "d" not in blocks["floor"]
    assert any('k_s of materials "mirror", "green" is lost' in sentence for sentence in lost)
    assert any('texture "tiles" of k_d' in sentence for sentence in lost)


def test_names_of_mtl_have_no_spaces_and_are_different(written):
    scene = dw.Scene(objects=[], materials={"a b": dw.Material(), "a_b": dw.Material(k_h=0.1)})
    text, lost = written(scene, "mtl")
    assert [line for line in text.splitlines() if line.startswith("newmtl")] == ["newmtl a_b", "newmtl a_b_2"]
    assert text.count("illum 2") == 1 and any('"a b" is called a_b' in sentence for sentence in lost)


@pytest.fixture
def gltf(tmp_path):
    def read(scene):
        dw.save_scene(scene, tmp_path / "scene.gltf")
        return json.loads((tmp_path / "scene.gltf").read_text(encoding="utf-8"))

    return read


def array(file, number):
    """The numbers of an accessor, checked against its view and buffer."""
    accessor = file["accessors"][number]
    view = file["bufferViews"][accessor["bufferView"]]
    data = base64.b64decode(file["buffers"][0]["uri"].partition(",")[2])
    assert len(data) == file["buffers"][0]["byteLength"] and view["byteOffset"] % 4 == 0
    kind = {5126: np.float32, 5125: np.uint32}[accessor["componentType"]]
    values = np.frombuffer(data, kind, offset=view["byteOffset"], count=view["byteLength"] // 4)
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
    assert len(values) == accessor["count"] * width
    return values.reshape(-1, width)


def test_gltf_is_whole(gltf):
    """What the specification requires of each part."""
    file = gltf(everything())
    assert file["asset"]["version"] == "2.0" and file["scenes"][file["scene"]]["nodes"] == list(range(11))
    known = {name for part in file["materials"] + [file] for name in part.get("extensions", {})}
    assert set(file["extensionsUsed"]) == known
    assert len(file["meshes"]) == 7 and len(file["materials"]) == 7
    for mesh in file["meshes"]:
        (primitive,) = mesh["primitives"]
        points, normals = (array(file, primitive["attributes"][key]) for key in ("POSITION", "NORMAL"))
        triangles = array(file, primitive["indices"]).reshape(-1, 3)
        accessor = file["accessors"][primitive["attributes"]["POSITION"]]
        assert accessor["min"] == points.min(axis=0).tolist() and accessor["max"] == points.max(axis=0).tolist()
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
        # Counter-clockwise seen from outside.
        a, b, c = (points[triangles[:, k]] for k in range(3))
        assert (np.sum(np.cross(b - a, c - a) * normals[triangles[:, 0]], axis=1) > 0).all()
        assert 0 <= primitive["material"] < 7
    empty = gltf(dw.Scene(objects=[], materials={}))
    assert empty["scenes"] == [{}] and "meshes" not in empty and "buffers" not in empty


def test_gltf_materials_by_hand(gltf, truth):
    file = gltf(truth)
    glass, mirror, _, floor = file["materials"]
    # (V.R)^50 is (N.H)^200: alpha^2 = 2 / 202, and roughness^2 = alpha.
    roughness = (2 / 202) ** 0.25
    assert mirror["pbrMetallicRoughness"]["roughnessFactor"] == pytest.approx(roughness)
    assert mirror["pbrMetallicRoughness"]["baseColorFactor"] == pytest.approx([0.12, 0.16, 0.2, 1])
    # F0 = 0.04 at an index of 1.5, times 17.5, is k_s = 0.7.
    assert mirror["extensions"] == {"KHR_materials_specular": {"specularColorFactor": pytest.approx([17.5] * 3)}}
    more = glass["extensions"]
    assert more["KHR_materials_ior"] == {"ior": 1.5} and more["KHR_materials_volume"]["thicknessFactor"] > 0
    assert mirror["doubleSided"] and not glass["doubleSided"]
    # C = 0.12 + 0.7, of which 0.7 / 0.82 goes through.
    assert glass["pbrMetallicRoughness"]["baseColorFactor"][0] == pytest.approx(0.82)
    assert more["KHR_materials_transmission"]["transmissionFactor"] == pytest.approx(0.7 / 0.82)
    assert floor["pbrMetallicRoughness"]["baseColorTexture"] == {"index": 0}
    assert floor["extensions"]["KHR_materials_specular"] == {"specularFactor": 0.0}
    metal = gltf(dw.Scene(objects=[], materials={"m": dw.Material(k_s=[0.9, 0.6, 0.2])}))["materials"][0]
    assert metal["pbrMetallicRoughness"]["metallicFactor"] == 1
    assert metal["pbrMetallicRoughness"]["baseColorFactor"] == pytest.approx([0.9, 0.6, 0.2, 1])


def test_gltf_lights_and_cameras_by_hand(gltf, truth):
    file = gltf(truth)
    (camera,) = file["cameras"]
    assert camera["perspective"]["yfov"] == pytest.approx(math.radians(61.92751306414704))
    assert camera["perspective"]["aspectRatio"] == pytest.approx(4 / 3)
    node = next(node for node in file["nodes"] if "camera" in node)
    back = np.asarray([0, 0.02, 6]) / np.linalg.norm([0, 0.02, 6])
    assert node["matrix"][8:11] == pytest.approx(back) and node["matrix"][12:15] == pytest.approx([0, 0.52, 6])
    # The spheres lie between (-2.5, -1, -2.2) and (1.9, 1.1, 1).
    middle = np.asarray([-0.3, 0.05, -0.6])
    light = file["extensions"]["KHR_lights_punctual"]["lights"][0]
    assert light["intensity"] == pytest.approx(math.pi * 0.9 * np.sum(([3, 5, 4] - middle) ** 2))


def test_coordinates_of_a_checkerboard_tell_its_colour():
    random = np.random.default_rng(5)
    for axes in ("xz", "y", "xyz", "zx"):
        checker = dw.Checker([[1, 0, 0], [0, 1, 0]], 0.7, axes)
        points = random.uniform(-9, 9, (200, 3)) * ([1, 0, 1] if axes == "xyz" else 1) + [0, 1.1, 0]
        u, v = np.floor(2 * (checker_coordinates(checker, points) % 1)).T
        cells = sum(np.floor(points[:, "xyz".index(axis)] / 0.7) for axis in axes)
        np.testing.assert_array_equal(u == v, cells % 2 == 0)
    assert checker_coordinates(dw.Checker([[1, 0, 0], [0, 1, 0]]), ball()[0]) is None


def test_a_polygon_with_a_dent_is_cut_into_its_triangles():
    star = [(np.cos(t) * r, np.sin(t) * r, 0.0) for t, r in zip(np.arange(10) * np.pi / 5, [2, 0.5] * 5, strict=True)]
    points = np.asarray(star)
    triangles = points[triangulated(points, np.asarray([0.0, 0.0, 1.0]))]
    areas = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])[:, 2] / 2
    assert len(areas) == 8 and (areas > 0).all()
    assert areas.sum() == pytest.approx(10 * 0.5 * 2 * 0.5 * np.sin(np.pi / 5))


# Mitsuba


def test_mitsuba_by_hand(tmp_path, truth):
    lost = dw.save_scene(truth, tmp_path / "scene.xml")
    root = ElementTree.parse(tmp_path / "scene.xml").getroot()
    assert root.tag == "scene" and root.get("version") == "3.0.0"
    numbers = {e.get("name"): e.get("value") for e in root.iter("float")}
    assert float(numbers["fov"]) == pytest.approx(61.92751306414704, rel=1e-7) and numbers["int_ior"] == "1.5"
    look = next(root.iter("lookat"))
    assert look.attrib == {"origin": "0, 0.52, 6", "target": "0, 0.5, 0", "up": "0, 1, 0"}
    assert [film.get("value") for film in root.iter("integer")][:3] == ["6", "320", "240"]
    ids = {bsdf.get("id") for bsdf in root.findall("bsdf")}
    assert ids == {ref.get("id") for ref in root.iter("ref")} and len(ids) == 4
    light = next(e for e in root.iter("emitter") if e.get("type") == "point").find("rgb").get("value")
    near = math.pi * 0.9 * np.sum(([3, 5, 4] - np.asarray([-0.3, 0.05, -0.6])) ** 2)
    assert [float(x) for x in light.split(",")] == pytest.approx([near] * 3)
    ply = (tmp_path / "scene_ground.ply").read_text().splitlines()
    assert ply[0] == "ply" and "element vertex 4" in ply and "property float u" in ply
    assert [shape.get("type") for shape in root.findall("shape")] == ["sphere"] * 3 + ["ply"]
    assert any("scene_ground.ply" in sentence for sentence in lost)


def test_blends_of_mitsuba_add_up(tmp_path, truth):
    """What a blend lets through of each part is the coefficient."""
    dw.save_scene(truth, tmp_path / "scene.xml")
    root = ElementTree.parse(tmp_path / "scene.xml").getroot()

    def parts(bsdf, share):
        if bsdf.get("type") == "blendbsdf":
            weight = float(bsdf.find("float").get("value"))
            first, second = bsdf.findall("bsdf")
            return {**parts(first, share * (1 - weight)), **parts(second, share * weight)}
        inner = bsdf.find("bsdf") if bsdf.get("type") == "twosided" else bsdf
        value = np.asarray([float(x) for x in inner.find("rgb").get("value").split(",")])
        return {inner.get("type"): value * share}

    found = parts(next(b for b in root.findall("bsdf") if b.get("id") == "material_green"), 1.0)
    np.testing.assert_allclose(found["diffuse"], [0.4, 0.7, 0.3], atol=1e-9)
    np.testing.assert_allclose(found["conductor"], 0.1, atol=1e-9)
    np.testing.assert_allclose(found["roughconductor"], 8 * 0.3 / 202, atol=1e-9)


# Numbers and tables


def test_json_holds_every_number_by_name(written):
    scene = everything()
    text, lost = written(scene, "json")
    content = json.loads(text)
    assert lost == ()
    assert list(content["parameters"]) == [p.name for p in dw.parameters(scene)]
    for p in dw.parameters(scene):
        about = content["parameters"][p.name]
        np.testing.assert_array_equal(np.asarray(about["value"], p.value(scene).dtype), np.asarray(p.value(scene)))
        assert about["unit"] == p.row.unit and about["meaning"] == p.row.meaning
    assert content["parameters"]["object.gold ball.radius"]["value"] == 0.8
    assert content["objects"]["sail"] == {"type": "triangle", "material": "dull"}
    assert content["textures"]["tiles"] == {"type": "checker", "axes": "xz"}
    assert content["settings"]["shadows"] == "opaque" and content["settings"]["max_depth"] == 6
    dotted = dw.Scene(objects=[dw.Sphere("a.b", [0, 0, 0], 1, "m")], materials={"m": dw.Material()})
    assert 'the numbers of object "a.b" are left out' in written(dotted, "json")[1][0]


def test_tables_of_materials(written):
    materials = {
        "50 % grey_$|": dw.Material(k_d=[0.123456, 0.5, 1e-7]),
        "glass": dw.Material(k_t=0.5, refractive_index=1.5),
    }
    scene = dw.Scene(objects=[], materials=materials)
    text, _ = written(scene, "tex")
    rows = [line.strip() for line in text.splitlines()]
    assert rows[rows.index(r"\toprule") + 1].startswith(r"material & $k_{a}$ & $k_{d}$")
    assert r"50 \% grey\_\$\textbar{} & $0$ & $0.1235$, $0.5$, $1 \times 10^{-7}$ & $0$" in text
    assert rows[-2:] == [r"\bottomrule", r"\end{tabular}"]
    text, _ = written(scene, "md")
    lines = text.splitlines()
    assert lines[0].startswith("| material | k_a | k_d |") and lines[3].startswith(
        "| glass | 0 | 0 | 0 | 0 | 0.5 | 50 | 1.5 |"
    )
    assert lines[2].startswith(r"| 50 % grey_$\| | 0 | 0.1235, 0.5, 1 × 10^-7 |")


@pytest.mark.parametrize("suffix", OUT)
def test_odd_names_do_no_harm(suffix, written):
    """Breaks of lines, quotes, ends of comments, half a pair of UTF-16, and two names that differ in these alone."""
    names = ["a\nb", "a--b -->", "}*/ //", 'q"\\', "\udc80", "{}", "$x$ & |"]
    scene = dw.Scene(
        objects=[dw.Polygon(name, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], name) for name in names],
        materials={name: dw.Material(k_a=0.1, k_d=0.1, k_s=0.2, highlight="reflected") for name in names},
        lights=[dw.PointLight([0, 0, 1], 1, name=name) for name in names],
    )
    text, _ = written(scene, suffix)
    if suffix in ("json", "gltf"):
        assert len(json.loads(text)["materials"]) == len(names)
    if suffix == "xml":
        assert len(ElementTree.fromstring(text).findall("shape")) == len(names)
    if suffix == "mtl":
        assert len({line for line in text.splitlines() if line.startswith("newmtl ")}) == len(names)
    if suffix == "pov":
        assert text.count("triangle {") == len(names) == sum(line.startswith("triangle") for line in text.splitlines())
    if suffix == "md":
        assert sum(line.startswith("| ") for line in text.splitlines()) == len(names) + 2


def test_files_beside_are_written_for_a_format_of_others(tmp_path):
    from diffwhitted.formats import SceneFormat, Written

    form = SceneFormat("two", (".two",), write=lambda scene, source: Written(b"1", ("two: all",), {"_b.bin": b"2"}))
    with including_format(form):
        assert dw.save_scene(dw.Scene(objects=[], materials={}), tmp_path / "a.two") == ("two: all",)
    assert form not in FORMATS
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a.two": b"1", "a_b.bin": b"2"}
