"""Scenes in other programs' files: glTF and GLB, OBJ with MTL, bare meshes. What they say, and what is told as lost."""

import json
import struct
import warnings

import numpy as np
import pytest
from mesh_samples import BOX, BOX_FACES, ball

import diffwhitted as dw
from diffwhitted._errors import SceneNote

CAMERA = dw.Camera((2.5, 2, 4), (0, 0, 0), 35, 24, 18)


def load(path, **how):
    """The scene, and the notes that came with it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = dw.load_scene(path, **how)
    return scene, " | ".join(str(one.message) for one in caught if issubclass(one.category, SceneNote))


def written(tmp_path, name="scene.gltf"):
    """A scene of ours in a file of theirs."""
    scene = dw.Scene(
        objects=[
            dw.Mesh("box", 0.7 * BOX, BOX_FACES, "clay"),
            dw.Mesh("pane", [[-2, -1, -2], [-2, -1, 2], [2, -1, 2], [2, -1, -2]], [[0, 1, 2, 3]], "chrome"),
            dw.Mesh("glass", 0.3 * BOX + [0, 1.2, 0], BOX_FACES, "glass"),
        ],
        materials={
            "clay": dw.Material(k_d=(0.6, 0.3, 0.2), k_h=0),
            "chrome": dw.Material(k_d=0, k_s=(0.9, 0.8, 0.7), phong_exponent=5000),
            "glass": dw.Material(
                k_d=0, k_h=0, k_s=0.04, k_t=(0.8, 0.9, 0.7), refractive_index=1.5, phong_exponent=5000
            ),
        },
        lights=[dw.DirectionalLight((1, 2, 3), (0.9, 0.8, 0.7), name="sun")],
        cameras={"eye": CAMERA},
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        dw.save_scene(scene, tmp_path / name)
    return scene


def test_a_scene_comes_back_from_gltf(tmp_path):
    """Materials by number, and the same picture: all of it but ambient light is in the file."""
    scene = written(tmp_path)
    back, _ = load(tmp_path / "scene.gltf")
    assert {thing.name for thing in back.objects} == {"box", "pane", "glass"}
    for name, material in scene.materials.items():
        for coefficient in ("k_d", "k_s", "k_t"):
            one, other = (np.broadcast_to(m.values[coefficient], 3) for m in (material, back.materials[name]))
            np.testing.assert_allclose(one, other, atol=2e-5, err_msg=f"{name}.{coefficient}")
    assert float(back.materials["glass"].values["refractive_index"]) == pytest.approx(1.5)
    camera = back.cameras["eye"]
    assert (camera.height, camera.width) == (480, 640)
    np.testing.assert_allclose(camera.look_from, CAMERA.look_from, atol=1e-6)
    assert float(camera.vfov_deg) == pytest.approx(35, abs=1e-4)
    same = {"shadows": "tinted", "max_depth": 6}
    pictures = []
    for one in (scene, back):
        one = dw.Scene(objects=one.objects, materials=one.materials, lights=one.lights, **same)
        pictures.append(np.asarray(dw.render(one, CAMERA)))
    assert (abs(pictures[0] - pictures[1]).max(axis=-1) > 1e-3).mean() < 0.01 and pictures[0].std() > 0.05


def test_glb_nodes_lights_and_what_is_lost(tmp_path):
    """Transforms multiply down the tree; a mirrored node keeps its outside; lights in candela; notes name the rest."""
    vertices, faces = ball(0)
    binary = vertices.astype("<f4").tobytes() + faces.astype("<u2").tobytes()
    turn = [0, np.sin(np.pi / 4), 0, np.cos(np.pi / 4)]
    content = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0, 2]}],
        "nodes": [
            {"translation": [1, 2, 3], "rotation": turn, "children": [1]},
            {"name": "ball", "scale": [-1, 2, 2], "mesh": 0},
            {"translation": [0, 5, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"name": "paint", "normalTexture": {"index": 0}, "emissiveFactor": [1, 0, 0],
                       "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1], "metallicFactor": 0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 12 * len(vertices)},
            {"buffer": 0, "byteOffset": 12 * len(vertices), "byteLength": 2 * faces.size},
        ],
        "buffers": [{"byteLength": len(binary)}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "color": [1, 0.5, 0], "intensity": 10}]}},
        "animations": [{}],
    }  # fmt: skip
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    (tmp_path / "s.glb").write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
    scene, said = load(tmp_path / "s.glb", precision="float64")
    (mesh,) = scene.objects
    assert mesh.name == "ball" and mesh.closed and not mesh.inside_out
    # A quarter turn about y takes x to -z and z to x.
    x, y, z = (vertices * [-1, 2, 2]).T
    np.testing.assert_allclose(mesh.vertices, np.stack([z + 1, y + 2, -x + 3], axis=1), atol=1e-6)
    (lamp,) = scene.lights
    np.testing.assert_allclose(lamp.colour, np.asarray([1, 0.5, 0]) * 10 / np.pi)
    np.testing.assert_allclose(lamp.attenuation, [0, 0, 1])
    np.testing.assert_allclose(scene.materials["paint"].values["k_d"], [0.2, 0.4, 0.6])
    for part in ("animations are lost", "cone of light 'light'", "emits is lost", "texture of normals"):
        assert part in said.replace('"', "'"), said


def broken(**changes):
    content = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
               "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
               "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
               "bufferViews": [{"buffer": 0}],
               "buffers": [{"uri": "data:application/octet-stream;base64," + "A" * 48}]}  # fmt: skip
    return json.dumps(content | changes)


@pytest.mark.parametrize(
    "content, said",
    [
        ("{", "broken JSON"),
        ("[]", "no asset"),
        (broken(asset={"version": "1.0"}), "glTF version '1.0'; allowed is 2.0"),
        (broken(nodes=[{"children": [0]}]), r"nodes\[0\] is its own descendant"),
        (broken(nodes=[{"mesh": 7}]), r"names meshes\[7\], and there are 1"),
        (broken(nodes=[{"mesh": 0, "scale": [1, "x", 1]}]), "scale"),
        (broken(accessors=[{"bufferView": 0, "componentType": 5126, "count": 10**8, "type": "VEC3"}]),
         "promises 100,000,000"),
        (broken(accessors=[{"bufferView": 0, "componentType": 1, "count": 3, "type": "VEC3"}]), "not described as"),
        (broken(buffers=[{"uri": "../secret.bin"}]), "is not beside the file"),
        (broken(buffers=[{"uri": "gone.bin"}]), "there is no file 'gone.bin'"),
        (broken(extensionsRequired=["KHR_draco_mesh_compression"]), "needs the extension KHR_draco_mesh_compression"),
        (broken(nodes=[{}]), "no node of its scene holds triangles"),
        (broken(), "none of its 1 triangles has an area"),
    ],
)  # fmt: skip
def test_broken_gltf(tmp_path, content, said):
    (tmp_path / "s.gltf").write_text(content)
    with pytest.raises(dw.SceneError, match=said):
        dw.load_scene(tmp_path / "s.gltf")


MTL = """
newmtl clay
Ka 0.1 0.1 0.1
Kd 0.6 0.3 0.2
Ks 0.2 0.2 0.2
Ns 30
illum 2
newmtl glass
Kd 0 0 0
Ks 0.05 0.05 0.05
Ns 200
Ni 1.5
d 0.2
illum 7
"""


def test_obj_with_its_materials(tmp_path):
    lines = ["mtllib m.mtl"]
    for material, shift in (("clay", 0), ("glass", 3)):
        lines += [f"v {x + shift} {y} {z}" for x, y, z in BOX.tolist()]
        first = 1 + 8 * (material == "glass")
        lines += [f"usemtl {material}", *(f"f {' '.join(str(k + first) for k in face)}" for face in BOX_FACES)]
    (tmp_path / "s.obj").write_text("\n".join(lines))
    (tmp_path / "m.mtl").write_text(MTL)
    scene, said = load(tmp_path / "s.obj")
    clay, glass = scene.materials["clay"].values, scene.materials["glass"].values
    np.testing.assert_allclose(clay["k_d"], [0.6, 0.3, 0.2], atol=1e-6)
    np.testing.assert_allclose([clay["k_h"][0], clay["phong_exponent"]], [0.2, 30], atol=1e-6)
    assert not np.any(clay["k_s"]) and not np.any(clay["k_t"])
    np.testing.assert_allclose(glass["k_t"], 0.8, atol=1e-6)
    np.testing.assert_allclose(glass["k_s"], 0.05, atol=1e-6)
    assert float(glass["refractive_index"]) == 1.5
    by_material = {thing.material: thing for thing in scene.objects}
    assert by_material["glass"].surfaces == 12 and by_material["glass"].closed
    assert float(np.min(by_material["glass"].vertices)) == -1 and "no camera and no light" in said
    camera = scene.cameras["main"]
    small = dw.Camera(camera.look_from, camera.look_at, 40, 24, 18)
    image = np.asarray(dw.render(scene, small))
    assert 0.1 < (image.max(axis=-1) > 0).mean() < 0.8


def test_a_bare_mesh_is_a_scene(tmp_path):
    vertices, faces = ball(1)
    body = b"".join(np.float32(0).tobytes() * 3 + vertices[f].astype("<f4").tobytes() + b"\0\0" for f in faces)
    (tmp_path / "ball.stl").write_bytes(b"\0" * 80 + struct.pack("<I", len(faces)) + body)
    scene, said = load(tmp_path / "ball.stl")
    assert scene.objects[0].closed and scene.objects[0].surfaces == len(faces) and "no camera" in said
    dw.save_scene(scene, tmp_path / "ball.toml")
    assert 'file = "ball.stl"' in (tmp_path / "ball.toml").read_text()
