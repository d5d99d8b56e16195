"""Meshes and sets of spheres in files: scene files that hold or name them, faults, and hostile mesh files."""

import warnings

import jax
import numpy as np
import pytest
from mesh_samples import BOX, BOX_FACES, ball

import diffwhitted as dw
from fitting.command_line._folder import saved_into


def cube(vertices=0.6 * BOX, faces=BOX_FACES, **more) -> dw.Mesh:
    return dw.Mesh("cube", vertices, faces, "glass", **more)


def test_scene_files(tmp_path):
    vertices, faces = ball(1)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces.tolist()]
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "ball.obj").write_text("\n".join(lines))
    np.savez(tmp_path / "dots.npz", centres=vertices, radii=np.full(len(vertices), 0.1))
    text = """
        [[material]]
        name = "clay"
        k_d = 0.5
        [[object]]
        name = "ball"
        type = "mesh"
        file = "parts/ball.obj"
        shading = "phong"
        material = "clay"
        [[object]]
        name = "roof"
        type = "mesh"
        vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]
        faces = [[0, 1, 2, 3]]
        uvs = [[0, 0], [1, 0], [1, 1], [0, 1]]
        material = "clay"
        [[object]]
        name = "dots"
        type = "spheres"
        file = "dots.npz"
        material = "clay"
        [[object]]
        name = "row"
        type = "spheres"
        centres = [[0, 0, 0], [1, 0, 0]]
        radii = 0.25
        material = "clay"
    """
    (tmp_path / "scene.toml").write_text(text)
    loaded = dw.load_scene(tmp_path / "scene.toml")
    of_file, roof, dots, row = sorted(loaded.objects, key=lambda o: ["ball", "roof", "dots", "row"].index(o.name))
    np.testing.assert_allclose(np.asarray(of_file.vertices)[np.asarray(of_file.faces)], vertices[faces], atol=1e-6)
    assert of_file.shading == "phong" and roof.faces.tolist() == [[3, 0, 1], [1, 2, 3]] or len(roof.faces) == 2
    assert dots.surfaces == len(vertices) and row.radii.shape == ()
    (tmp_path / "elsewhere").mkdir()
    dw.save_scene(loaded, tmp_path / "elsewhere" / "again.toml")
    said = (tmp_path / "elsewhere" / "again.toml").read_text()
    assert 'file = "../parts/ball.obj"' in said and said.count("vertices") == 1
    again = dw.load_scene(tmp_path / "elsewhere" / "again.toml")
    for one, other in zip(jax.tree.leaves(loaded), jax.tree.leaves(again), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_scene_that_is_made_elsewhere_names_its_meshes_from_where_it_goes(tmp_path, monkeypatch):
    """As `fit --out` makes fitted.toml: in a folder of its own, which is then put in place."""
    monkeypatch.chdir(tmp_path)
    vertices, faces = ball(0)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    (tmp_path / "ball.obj").write_text(
        "\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces.tolist())])
    )
    scene = dw.Scene(objects=[dw.Mesh("m", material="p", file="ball.obj")], materials={"p": dw.Material(k_d=0.5)})
    made, out = tmp_path / "made", tmp_path / "some" / "where"
    for folder in (made, out):
        folder.mkdir(parents=True)
    saved_into(out)(scene, made / "fitted.toml")
    (made / "fitted.toml").rename(out / "fitted.toml")
    again = dw.load_scene(out / "fitted.toml")
    assert 'file = "../../ball.obj"' in (out / "fitted.toml").read_text()
    np.testing.assert_array_equal(again.objects[0].vertices, scene.objects[0].vertices)


@pytest.mark.parametrize(
    "wrong, said",
    [
        ({"faces": [[0, 1, 8]]}, r"faces\[0\] = \[0, 1, 8\], and there are 8 vertices; allowed is 0 to 7"),
        ({"faces": [[0, 1, 2], [0, -1, 2]]}, r"faces\[1\] = \[0, -1, 2\]"),
        ({"faces": [[0, 1]]}, r"faces\[0\] has 2 vertices; allowed is three or more"),
        ({"faces": []}, "faces is empty"),
        ({"faces": [[0, 1, 1.5]]}, "allowed is whole numbers"),
        ({"vertices": BOX * np.nan}, "vertices .* is not finite"),
        ({"vertices": BOX * 0}, "none of its 12 triangles has an area"),
        ({"normals": BOX[:3]}, "normals has 3 entries for 8 vertices"),
        ({"uvs": [[0, 0]]}, "uvs has 1 entries"),
        ({"shading": "gourd"}, "shading = 'gourd'; allowed is flat, gouraud, fast_phong, phong"),
        ({"vertices": None, "faces": None}, "needs vertices and faces, or a file"),
    ],
)
def test_errors(wrong, said):
    with pytest.raises(dw.SceneError, match=f"(?s)object 'cube': .*{said}"):
        cube(**{"vertices": BOX, "faces": BOX_FACES} | wrong)


def test_triangles_without_area_are_left_out_with_a_note():
    with pytest.warns(dw.SceneNote if hasattr(dw, "SceneNote") else UserWarning, match="1 of 13 triangles"):
        mesh = cube(faces=[*BOX_FACES, [0, 0, 1]])
    assert mesh.surfaces == 12 and mesh.closed


@pytest.mark.parametrize(
    "name, content, said",
    [
        ("none.obj", None, "there is no such file"),
        ("empty.ply", b"", "is empty"),
        ("mesh.xyz", b"1 2 3", "ends with '.xyz'; allowed is .obj, .ply"),
        ("huge.stl", b"\0" * 80 + (10**8).to_bytes(4, "little") + b"\0" * 50,
         "promises 100,000,000 triangles and holds 1"),
        ("huge.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 900000000\nproperty float x\nend_header\n",
         "promises 900,000,000 elements"),
        ("text.obj", b"hello\nworld\n", "holds no triangle|cannot be read"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a vertex is not finite"),
        ("outside.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "cannot be read|allowed is 0 to"),
    ],
)  # fmt: skip
def test_hostile_files(tmp_path, name, content, said):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(dw.SceneError, match=f"object 'm': file = .*({said})"):
            dw.Mesh("m", material="clay", file=str(tmp_path / name))
