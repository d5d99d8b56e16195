"""Scenes of POV-Ray: what our own writer makes comes back, a file by hand against POV-Ray's own picture, and what is
refused.
"""

import warnings

import numpy as np
import pytest
from leaving_samples import everything
from scene_reader import reader

import diffwhitted as dw
from diffwhitted._errors import SceneError

HAND = """// A still life. povray +Ihand.pov +W32 +H24 -A +FE
#version 3.7;
#include "colors.inc"
global_settings { assumed_gamma 1.0 max_trace_level 6 ambient_light rgb <1, 0.9, 0.8> }
#declare Size = 2/4 + 0.1*sqrt(4);           // 0.7
#declare Shiny = finish { ambient 0.15 diffuse 0.65 phong 0.5 phong_size 60 reflection 0.2 }
#declare Paint = texture { pigment { color rgb <0.8, 0.3, 0.2>*0.9 } finish { Shiny } }
#declare Peg = union {
  cylinder { <0, -1, 0>, <0, 0, 0>, 0.15 }
  cone { <0, 0, 0>, 0.3, <0, 0.6, 0>, 0.05 }
  texture { pigment { Green*0.5 + Blue*0.25 } finish { ambient 0.1 diffuse 0.7 specular 0.4 roughness 0.02 } }
}
camera { location <0.5, 1.2, -5> look_at <0, -0.1, 0> right x*image_width/image_height angle 50 }
background { color rgb <0.2, 0.3, 0.5> }
light_source { <-4, 6, -5>, rgb <0.9, 0.85, 0.8> }
light_source { <5, 5, -3>*1.5 color White*0.3 parallel point_at 0 }
light_source { <0, 2, 3>, rgb 0.8 fade_distance 2 fade_power 2 }
plane { y, -1
  pigment { checker color White, rgb <0.2, 0.25, 0.3> scale 0.8 translate <0.3, 0, 0.1> }
  finish { ambient 0.1 diffuse 0.7 } }
sphere { 0, 1 scale Size texture { Paint } translate <-0.9, -0.3, 0.4> }
sphere { <0, 0, 0>, 0.5
  pigment { rgbt <0.9, 0.95, 1, 0.8> }
  finish { ambient 0 diffuse 0.3 specular 0.6 roughness 0.01 reflection { 0, 1 fresnel on }
    conserve_energy }
  interior { ior 1.4 } scale <1.2, 0.7, 1> translate <0.7, -0.6, -0.8> }
object { Peg rotate <0, 0, -20> translate <1.4, -0.05, 1> }
#ifdef (Missing) sphere { 0, 100 } #else
torus { 0.5, 0.15 texture { Paint } rotate <60, 30, 0> translate <0.2, 0.4, 1.5> }
#end
box { -0.3, 0.3 pigment { rgb <0.3,0.4,0.9> } finish { ambient 0.2 diffuse 0.6 } rotate y*35 translate <-0.2,-0.7,-1> }
mesh2 { vertex_vectors { 4, <-2.2,-1,1>, <-1.2,-1,1.8>, <-1.9,-1,2.4>, <-1.8,0.9,1.7> }
  face_indices { 4, <0,1,3>, <1,2,3>, <2,0,3>, <0,2,1> } texture { Paint pigment { rgbf <0.9,0.8,0.2,0.1> } } }
/* smooth */ smooth_triangle { <1.6,-1,-0.6>, <-0.5,0.2,-1>, <2.4,-1,-0.2>, <0.5,0.2,-1>, <2,0.2,-0.3>, <0,1,-0.5>
  pigment { Yellow } }
disc { <-2.2, 0.6, 0.2>, <1, -0.2, -1.5>, 0.45 texture { Paint finish { ambient 0.3 diffuse 0.4 } } }
triangle { <1.5,1.6,2>, <2.6,1.2,2>, <2.2,2.1,2.4> pigment { Red } }
"""
PIXELS = {
    (2, 16): (0.19995, 0.30005, 0.5), (4, 29): (0.30591, 0.29199, 0.27832), (6, 2): (0.51318, 0.27026, 0.21436),
    (9, 17): (0.46777, 0.17285, 0.11945), (10, 25): (0.00893, 0.2522, 0.12469), (12, 30): (0.65479, 0.62207, 0.0),
    (13, 9): (0.58691, 0.30981, 0.24634), (13, 4): (0.69434, 0.65918, 0.62354), (14, 24): (0.84766, 0.81592, 0.78369),
    (16, 21): (0.23157, 0.25, 0.27124), (17, 20): (0.61377, 0.59717, 0.58496), (18, 14): (0.10089, 0.12646, 0.2666),
    (22, 5): (0.1532, 0.18164, 0.20618), (22, 16): (0.14624, 0.17346, 0.1969),
}  # fmt: skip
"""Rows and columns of POV-Ray 3.7's picture, half floats."""


@pytest.fixture
def read(tmp_path):
    """The scene of a text, and the notes on it."""
    return reader(tmp_path / "scene.pov", " ".join)


@pytest.mark.slow
def test_a_file_by_hand_is_povrays_picture(read):
    scene, said = read(HAND)
    image = np.asarray(dw.render(scene, scene.cameras["main"]))
    assert image.shape == (24, 32, 3)
    for (row, column), theirs in PIXELS.items():
        np.testing.assert_allclose(image[row, column], theirs, atol=4e-4, err_msg=f"row {row}, column {column}")
    assert [m.fresnel for m in scene.materials.values()].count("exact") == 1
    kinds = [type(thing).__name__ for thing in scene.objects]
    assert kinds == "Plane Sphere Quadric Cylinder Cone Torus Box Mesh Mesh Disc Polygon".split()
    assert "checkerboard of material" in said and said.count("lost") == 1 and "1 - F" not in said


def test_what_is_written_comes_back(tmp_path):
    """The same picture, names and cameras, of layers, boards within boards, coloured glass and opaque shadows."""
    cameras = {
        "main": dw.Camera([0.3, 0.8, 6], [0, 0.1, 0], 38, 16, 12, up=[0.1, 1, 0.2]),
        "side": dw.Camera([5, 1, 0], [0, 0, 0], focal=[30, 40], width=16, height=12, principal_point=[6, 7]),
        "flat": dw.OrthographicCamera([0, 1, 6], [0, 0, 0], 5.0, 16, 12),
    }
    usual = everything()
    keys = ("objects", "materials", "lights", "textures", "background", "ambient", "max_depth", "shadows")
    scene = dw.Scene(**{key: getattr(usual, key) for key in keys}, cameras=cameras)
    dw.save_scene(scene, tmp_path / "scene.pov")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        back = dw.load_scene(tmp_path / "scene.pov")
    assert [thing.name for thing in back.objects] == [thing.name for thing in scene.objects]
    assert [thing.material for thing in back.objects] == [thing.material for thing in scene.objects]
    assert [light.name for light in back.lights] == [light.name for light in scene.lights]
    assert {*back.materials} == {*scene.materials} - {"unused"}
    assert (back.shadows, back.max_depth, float(back.cutoff)) == (scene.shadows, scene.max_depth, 0)
    for name, camera in cameras.items():
        for key in ("vfov_deg", "view_height", "focal", "principal_point"):
            one, other = getattr(camera, key, None), getattr(back.cameras[name], key, None)
            assert (one is None) == (other is None)
            if one is not None:
                np.testing.assert_allclose(one, other, rtol=1e-5)
    # All numbers of what is drawn, so that the picture is the same: of the two boards, times their coefficient.
    one, other = ({p.name: np.asarray(p.value(s)) for p in dw.parameters(s)} for s in (scene, back))
    others = ("texture.", "camera.", "light.", "unused.", "dull.", "floor.k_s", "object.ground.")
    for name in (name for name in one if not name.startswith(others)):
        np.testing.assert_allclose(*np.broadcast_arrays(one[name], other[name]), atol=2e-6, err_msg=name)
    floors = [s.materials["floor"] for s in (scene, back)]
    for coefficient in ("k_d", "k_s"):
        pair = [s.textures[dict(f.textures)[coefficient]] for s, f in zip((scene, back), floors, strict=True)]
        colours = [t.colours * f.values[coefficient] for t, f in zip(pair, floors, strict=True)]
        np.testing.assert_allclose(*colours, atol=1e-6)
        assert pair[0].axes == pair[1].axes and float(pair[0].size) == pytest.approx(float(pair[1].size))


@pytest.mark.slow
def test_what_comes_back_is_the_same_picture(tmp_path):
    scene = everything()
    camera = scene.cameras["main"].resized(width=16, height=12)
    dw.save_scene(scene, tmp_path / "scene.pov")
    ours, theirs = (np.asarray(dw.render(s, camera)) for s in (scene, dw.load_scene(tmp_path / "scene.pov")))
    assert abs(ours - theirs).max() < 1e-4 and ours.std() > 0.05


def test_every_shape_comes_back(tmp_path):
    """Their numbers, where a transform has taken them; a polyhedron as its triangles."""
    material = {"m": dw.Material(k_d=0.5, k_h=0.0)}
    turned = dict(rotate_deg=[20, 30, 40], translate=[1, 2, 3])
    octahedron = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -1, -1]]
    objects = [
        dw.Box("box", [0, 0, 0], [1, 2, 3], "m"),
        dw.Box("turned", [0, 0, 0], [1, 2, 3], "m").placed(**turned),
        dw.Disc("disc", [1, 2, 3], [0, 1, 1], 2, "m"),
        dw.Cylinder("tube", [0, 1, 2], [1, 1, 3], 0.5, "m", capped=False),
        dw.Cone("cone", [0, 1, 2], [1, 1, 3], 0.5, 0.25, "m"),
        dw.Torus("ring", [1, 2, 3], [1, 1, 1], 2, 0.5, "m"),
        dw.Quadric("egg", [1, 2, 3, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, -7], "m").placed(**turned),
        dw.Quadric("saddle", [1, -2, 0, 0, 0, 0, 0, 0, -1, 0], "m", [-1, -1, -1], [1, 2, 3]),
        dw.Polyhedron("solid", octahedron, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]], "m"),
        dw.SphereSet("balls", [[0, 0, 0], [1, 2, 3]], [0.5, 0.25], "m"),
        dw.Mesh("mesh", octahedron, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]], "m", shading="flat"),
    ]
    scene = dw.Scene(objects=objects, materials=material, lights=[dw.PointLight([9, 9, 9], 1)], precision="float64")
    dw.save_scene(scene, tmp_path / "scene.pov")
    back = dw.load_scene(tmp_path / "scene.pov", precision="float64")
    one, other = ({thing.name: thing for thing in s.placed_objects()} for s in (scene, back))
    assert [*one] == [*other]
    same = {"box": ("minimum", "maximum"), "disc": ("centre", "radius"), "tube": ("base", "top", "radius", "capped"),
            "cone": ("base", "top", "base_radius", "top_radius"), "ring": ("centre", "major_radius", "minor_radius"),
            "saddle": ("minimum", "maximum"), "balls": ("centres", "radii"), "mesh": ("vertices",)}  # fmt: skip
    for name, keys in same.items():
        assert type(one[name]) is type(other[name])
        for key in keys:
            np.testing.assert_allclose(getattr(one[name], key), getattr(other[name], key), atol=1e-9, err_msg=name)
    for name in ("disc", "ring"):
        axes = (np.asarray(getattr(thing[name], "normal" if name == "disc" else "axis")) for thing in (one, other))
        first, second = axes
        assert abs(first @ second) == pytest.approx(np.linalg.norm(first) * np.linalg.norm(second))
    # A quadric is 0 in the same places: the frames may be mirror images.
    points = np.random.default_rng(1).normal(size=(20, 3))
    for name in ("egg", "saddle"):
        np.testing.assert_allclose(_height(one[name], points), _height(other[name], points), atol=1e-8)
    assert other["solid"].closed and not other["solid"].inside_out and len(other["solid"].faces) == 4
    assert other["mesh"].closed and not other["mesh"].inside_out
    middle, radius = one["turned"].ball()
    assert np.allclose(other["turned"].ball()[0], middle) and other["turned"].ball()[1] == pytest.approx(radius)


def _height(quadric, points):
    """Its polynomial at points of the scene."""
    frame = np.eye(3, 4) if quadric.frame is None else np.asarray(quadric.frame)
    x, y, z = np.linalg.solve(frame[:, :3], (points - frame[:, 3]).T)
    return np.asarray(quadric.coefficients) @ [x * x, y * y, z * z, x * y, x * z, y * z, x, y, z, np.ones_like(x)]


def test_words_of_the_language(read):
    """Conditions, includes of the folder, right-handed cameras, layers and defaults."""
    text = """#declare N = 3; #declare V = <1, 2, 3> + 2*y; #local W = vlength(<3, 4, 0>).x;
    #default { finish { ambient 0.25 diffuse 0.5 } }
    #if (N = 3 & 1) #end
    #if (N > 2) sphere { V, W pigment { rgb <1, 0.5, 0.25> } } #else plane { y, 0 } #end
    #switch (N) #case (1) plane { y, 0 } #break #range (2, 4) box { 0, V } #break #else plane { y, 1 } #end
    camera { location <0, -5, 1> sky z right -x*4/3 look_at <0, 0, 1> }
    difference { box { -1, 1 } sphere { 0, 1 } }
    sphere { 0, 1 texture { pigment { rgb <0.8, 0, 0> } finish { ambient 0 diffuse 1 } }
      texture { pigment { rgbf <0.5, 1, 1, 0.75> } finish { ambient 0 diffuse 0.5 phong 0.3 } } no_shadow }
    light_source { <1, 2, 3> White spotlight radius 10 falloff 20 point_at 0 }"""
    with pytest.raises(SceneError, match="line 3"):
        read(text)
    scene, said = read('#include "colors.inc"\n' + text.replace("(N = 3 & 1)", "(N = 4)"), precision="float64")
    ball, box, coated = scene.objects
    # The camera's axes are right-handed, and so are all others.
    np.testing.assert_allclose(ball.centre, [1, 4, 3])
    assert float(ball.radius) == 5
    np.testing.assert_allclose(box.maximum, [1, 4, 3])
    np.testing.assert_allclose(scene.cameras["main"].look_from, [0, -5, 1])
    np.testing.assert_allclose(scene.materials[ball.material].k_a, [0.25, 0.125, 0.0625])
    # The upper layer keeps a quarter of its own light, and multiplies what is below by 0.75 P.
    coat = scene.materials[coated.material]
    np.testing.assert_allclose(coat.k_d, 0.25 * 0.5 * np.asarray([0.5, 1, 1]) + 0.75 * np.asarray([0.4, 0, 0]))
    np.testing.assert_allclose([coat.k_h[0], float(coat.phong_exponent)], [0.3, 40])
    assert coat.highlight == "reflected" and float(scene.cutoff) == pytest.approx(1 / 255)
    for words in ("left out: difference", "spotlight is lost", "no_shadow is lost", "640 x 480"):
        assert words in said, said


DOUBLED = "#declare A0 = union { sphere { 0, 1 } sphere { 0, 2 } }\n" + "".join(
    f"#declare A{k} = union {{ object {{ A{k - 1} }} box {{ 0, 1 }} object {{ A{k - 1} }} }}\n" for k in range(1, 40)
)
COATS = "#declare T0 = texture { pigment { rgb 1 } }\n" + "".join(
    f"#declare T{k} = texture {{ T{k - 1} }} texture {{ T{k - 1} }}\n" for k in range(1, 40)
)


@pytest.mark.parametrize(
    "text, said",
    [
        ("", "no shape in it"),
        ("sphere {", "line 1: the end of the file where a number"),
        ("sphere { 0, 1\n\n", "line 1: sphere { has no end"),
        ("sphere { 0, 1 }\n#while (1) #end", "line 2: #while is not read"),
        ("\n#macro A() #end", "line 2: #macro is not read"),
        ("#if (1) sphere { 0, 1 }", "#if has no #end"),
        ("#if (0) sphere { 0, 1 }", "has no #end"),
        ("#declare A = A;", "line 1: 'A' where a number or a vector should be"),
        ("#declare A = 1/0;", "line 1: a division by 0"),
        ("#declare A = 1e300*1e300;", "is not finite, or above 1e30"),
        ("#declare A = sqrt(-1);", "is not finite"),
        ("#declare A[3];", "array A is not read"),
        ("sphere { 0, -1 }", "line 1: object 'sphere': radius = -1"),
        ("sphere { 0, 1 scale 1e40 }", "not finite, or above 1e30"),
        ("sphere { 0, 1 flatten }", "'flatten' in sphere; allowed are texture"),
        ("sphere { 0, 1 texture { shiny } }", "'shiny' in a texture"),
        ("sphere { 0, 1 finish { shiny 1 } }", "'shiny' in a finish"),
        ("bicycle { 0, 1 }", "line 1: 'bicycle' is no statement"),
        ("object { Nobody }", "'Nobody' is no object"),
        ("#include \"gone.inc\"", "there is no such file in the folder"),
        ("#include \"../secret.inc\"", "there is no such file in the folder"),
        ("#include \"scene.pov\"", "or more than 32 files"),
        ("union {" * 200, "more than 80 deep"),
        ("#declare A = " + "(" * 5000, "more than 80 deep"),
        ("mesh2 { vertex_vectors { 1e12, ", "allowed is a whole number up to"),
        ("mesh2 { vertex_vectors { 3, 0, x, y } face_indices { 1, <0, 1, 7> } }", "names a point that is not there"),
        ("polygon { 3, 0, x }", "where a number or a vector should be"),
        (DOUBLED + "object { A39 }", "more than 1,000 objects"),
        (COATS + "sphere { 0, 1 texture { T39 } }", "more than 256 layers"),
        ("sphere { 0, 1 pigment { rgb -1 } }", "a colour [-1.0, -1.0, -1.0, 0.0, 0.0]; allowed is >= 0"),
        ("/* open", "line 1: a comment /* without its end"),
        (b"sphere \x00\x01", "line 1: this is not text"),
        (b"\x89PNG\r\n\x1a\n", "means nothing here"),
        ("camera { location 0 look_at 0 }", "looks at its own place"),
    ],
)  # fmt: skip
def test_hostile_files_are_refused_by_line(read, text, said, monkeypatch):
    monkeypatch.setattr("diffwhitted.formats.others._found.MOST_OBJECTS", 1000)
    with pytest.raises(SceneError, match="scene.pov") as error:
        read(text)
    assert said in str(error.value)
