"""Scenes of Mitsuba 3: what our own writer makes comes back, files by hand, and what is refused."""

import numpy as np
import pytest
from scene_reader import reader

import diffwhitted as dw
from diffwhitted._errors import SceneError, SceneNote

HAND = """<?xml version="1.0"?>
<scene version="3.0.0">
  <default name="width" value="40"/> <default name="grey" value="0.25"/>
  <integrator type="path"><integer name="max_depth" value="6"/></integrator>
  <include filename="paints.xml"/>
  <sensor type="perspective">
    <float name="fov" value="60"/>
    <transform name="to_world"><lookat origin="0, 1, 5" target="0, 1, 0" up="0 1 0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="$width"/> <integer name="height" value="20"/>
      <integer name="crop_offset_x" value="4"/> <integer name="crop_width" value="30"/>
    </film>
  </sensor>
  <emitter type="directional"><vector name="direction" y="-2"/><rgb name="irradiance" value="$grey"/></emitter>
  <emitter type="point"><point name="position" x="1" y="2" z="3"/><rgb name="intensity" value="1 2 3"/></emitter>
  <emitter type="constant"><rgb name="radiance" value="#ff8000"/></emitter>
  <emitter type="envmap" id="sky"><string name="filename" value="sky.exr"/></emitter>
  <shape type="sphere">
    <point name="center" x="1" y="0" z="0"/><float name="radius" value="2"/>
    <transform name="to_world"><scale value="0.5"/><rotate z="1" angle="90"/><translate x="3"/></transform>
    <ref id="paint"/>
  </shape>
  <shape type="cube"><transform name="to_world"><scale x="1" y="2" z="3"/></transform><ref id="glass"/></shape>
  <shape type="rectangle">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
      <rgb name="color0" value="0.1"/><rgb name="color1" value="0.9"/>
      <transform name="to_uv"><scale value="4"/></transform>
    </texture></bsdf></bsdf>
  </shape>
  <shape type="disk"><bsdf type="conductor"><string name="material" value="Au"/></bsdf></shape>
  <shape type="cylinder"><point name="p1" x="0" y="2" z="0"/><bsdf type="roughplastic">
    <float name="alpha" value="0.2"/><rgb name="diffuse_reflectance" value="0.4"/></bsdf></shape>
  <shape type="rectangle" id="lamp"><emitter type="area"><rgb name="radiance" value="3"/></emitter></shape>
  <shape type="hair"/>
</scene>
"""
PAINTS = """<scene version="3.0.0">
  <bsdf type="phong" id="paint"><float name="exponent" value="20"/>
    <rgb name="diffuse_reflectance" value="0.3, 0.2, 0.1"/><rgb name="specular_reflectance" value="0.05"/></bsdf>
  <bsdf type="dielectric" id="glass"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
</scene>"""


@pytest.fixture
def read(tmp_path):
    """The scene of a text, and the notes on it."""
    return reader(tmp_path / "scene.xml", " ".join)


def written() -> dw.Scene:
    """All that the writer says without loss."""
    materials = {
        "floor": dw.Material(k_d=0.8, k_h=0.0, k_d_texture="tiles"),
        "paint": dw.Material(k_d=[0.3, 0.2, 0.1], k_h=[0.4, 0.3, 0.2], phong_exponent=20),
        "mirror": dw.Material(k_d=0.1, k_s=[0.5, 0.4, 0.3], k_h=0.0),
        "film": dw.Material(k_d=0.1, k_t=[0.5, 0.8, 0.6], k_h=0.0),
    }
    corners, faces = [[2, -1, 1], [3, -1, 1], [2.5, -1, 0], [2.5, 0, 0.5]], [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]
    objects = [
        dw.Polygon("floor", [[-4, -1, 4], [4, -1, 4], [4, -1, -4], [-4, -1, -4]], "floor"),
        dw.Sphere("ball", [-1.2, 0, 0.5], 0.9, "mirror"),
        dw.Sphere("bubble", [1.3, -0.2, -0.5], 0.8, "film"),
        dw.Box("box", [0, -1, 0.8], [0.7, -0.4, 1.4], "paint"),
        dw.Plane("wall", [0, 0, 1], -5, "paint"),
        dw.Mesh("tetra", corners, faces, "mirror", shading="flat"),
    ]
    return dw.Scene(
        objects=objects,
        materials=materials,
        textures={"tiles": dw.Checker([[0.9, 0.1, 0.1], [1, 1, 1]], 0.7, "xz")},
        lights=[
            dw.DirectionalLight([0.3, 2, 1], [0.5, 0.4, 0.3], name="sun"),
            dw.PointLight([3, 5, 4], [20.0, 18, 15], attenuation=(0, 0, 1), attenuation_limit="none"),
        ],
        background=dw.ConstantBackground([0.2, 0.3, 0.4]),
        ambient=[0, 0, 0],
        shadows="tinted",
        cameras={
            "main": dw.Camera([0.3, 0.8, 6], [0, 0.1, 0], 38, 16, 12, up=[0.1, 1, 0.2], principal_point=[6, 7]),
            "flat": dw.OrthographicCamera([0, 1, 6], [0, 0, 0], 5.0, 16, 12),
        },
        max_depth=4,
    )


def test_what_is_written_comes_back(tmp_path):
    """The same picture; names of objects and materials, and both cameras."""
    scene = written()
    dw.save_scene(scene, tmp_path / "scene.xml")
    with pytest.warns(SceneNote):
        back = dw.load_scene(tmp_path / "scene.xml")
    assert [thing.name for thing in back.objects] == [thing.name for thing in scene.objects]
    assert [thing.material for thing in back.objects] == [thing.material for thing in scene.objects]
    for name, material in scene.materials.items():
        for coefficient in ("k_d", "k_s", "k_t", "k_h", "refractive_index"):
            one, other = (np.broadcast_to(m.at_work(coefficient), 3) for m in (material, back.materials[name]))
            np.testing.assert_allclose(one, other, atol=1e-6, err_msg=f"{name}.{coefficient}")
    one, other = list(scene.cameras.values()), list(back.cameras.values())
    np.testing.assert_allclose(one[0].principal_point, other[0].principal_point, atol=1e-5)
    assert float(other[0].vfov_deg) == pytest.approx(38, abs=1e-5)
    assert float(other[1].view_height) == pytest.approx(5, abs=1e-5)
    ours, theirs = (np.asarray(dw.render(s, c)) for s, c in ((scene, one[0]), (back, other[0])))
    assert abs(ours - theirs).max() < 1e-4 and ours.std() > 0.05


def test_a_file_by_hand(read, tmp_path):
    (tmp_path / "paints.xml").write_text(PAINTS)
    scene, said = read(HAND, precision="float64")
    ball, cube, floor, disc, tube = scene.objects
    # Half as large about the origin, a quarter turn, three to the right.
    np.testing.assert_allclose(ball.centre, [3, 0.5, 0], atol=1e-12)
    assert float(ball.radius) == 1
    np.testing.assert_allclose([cube.minimum, cube.maximum], [[-1, -2, -3], [1, 2, 3]])
    np.testing.assert_allclose(np.sort(floor.vertices, axis=0)[[0, -1]], [[-4, 0, -4], [4, 0, 4]], atol=1e-12)
    assert not tube.capped and float(disc.radius) == 1
    paint, glass = (scene.materials[name].values for name in ("paint", "glass"))
    np.testing.assert_allclose(paint["k_d"], [0.3, 0.2, 0.1])
    np.testing.assert_allclose(paint["k_h"], 0.05 * 22 / 2)
    assert (float(paint["phong_exponent"]), scene.materials["paint"].highlight) == (20, "reflected")
    np.testing.assert_allclose([glass["k_t"][0], glass["k_s"][0], glass["refractive_index"]], [1, 1, 1.5])
    assert scene.materials["glass"].fresnel == "exact" and scene.materials[disc.material].class_ == "metal"
    np.testing.assert_allclose(scene.materials[disc.material].k_s, [1, 0.766, 0.336])
    # alpha = 0.2 is n = 48, of F0 = (0.49 / 2.49)^2 with the index of air below it.
    plastic = scene.materials[tube.material]
    n = 1.49 / 1.000277
    np.testing.assert_allclose(plastic.k_h, ((n - 1) / (n + 1)) ** 2 * 50 / 8)
    assert float(plastic.phong_exponent) == pytest.approx(48)
    assert float(plastic.k_d[0]) == pytest.approx(0.4068, abs=1e-4)
    # Four of u are eight cells of 8 m; u and v are both 0 in one corner, where the first colour begins.
    tiles = scene.textures[scene.materials[floor.material].k_d_texture]
    assert (float(tiles.size), tiles.axes) == (1, "xz")
    np.testing.assert_allclose(np.ravel(tiles.colours[:, 0]) * 0.9, [0.9, 0.1])
    sun, bulb, lamp = scene.lights
    np.testing.assert_allclose(sun.direction, [0, 2, 0], atol=1e-12)
    np.testing.assert_allclose([sun.colour, bulb.colour], [np.full(3, 0.25 / np.pi), np.asarray([1, 2, 3]) / np.pi])
    # A square of 4 m^2 sends 12 straight ahead.
    np.testing.assert_allclose(lamp.colour, 12 / np.pi)
    np.testing.assert_allclose(scene.background.colour, [1, 0.2158605, 0], atol=1e-6)
    # 60 degrees are across; a crop is pixels of the whole.
    camera = scene.cameras["main"]
    assert float(camera.vfov_deg) == pytest.approx(np.degrees(2 * np.arctan(np.tan(np.pi / 6) / 2)))
    assert camera.crop == (4, 0, 30, 20) and camera.full == (40, 20) and scene.max_depth == 5
    for words in ('left out: light "sky" (envmap)', 'left out: shape "shape (hair)"', 'left out: shape "lamp"'):
        assert words in said


SPHERE = "<scene><shape type='sphere'>%s</shape></scene>"


@pytest.mark.parametrize(
    "text, said",
    [
        ("", "broken XML: no element found"),
        ("<scene>", "line 1: broken XML"),
        ("<html/>", "this is <html>"),
        ("<!DOCTYPE scene [<!ENTITY a 'b'>]>\n<scene/>", "line 1: a DOCTYPE is not read"),
        ("<scene>\n<shape type='sphere'><float name='radius' value='nan'/></shape></scene>", "line 2: 'nan' in value"),
        (SPHERE % "<float name='radius' value='$r'/>", "$r has no value"),
        (SPHERE % "<ref id='gold'/>", "<ref id='gold'> names nothing"),
        (SPHERE % "<transform name='to_world'><scale value='0'/></transform>", "a transform makes it flat"),
        (SPHERE % "<transform name='to_world'><turn/></transform>", "<turn> in a transform"),
        (SPHERE % "<float name='radius' value='-1'/>", "radius = -1"),
        ("<scene>" + "<a>" * 5000, "more than 64 deep"),
        ("<scene>" + "<a/>" * 500_001 + "</scene>", "more than 500,000 elements"),
        ("<scene>\n<include filename='../secret.xml'/></scene>", "line 2: file '../secret.xml' is not within"),
        ("<scene><include filename='scene.xml'/></scene>", "does one include itself?"),
        ("<scene><shape type='ply'><string name='filename' value='gone.ply'/></shape></scene>", "is no such file"),
        ("<scene><sensor type='perspective'><float name='fov' value='190'/></sensor></scene>", "fov = 190"),
        ("<scene><default name='a' value='" + "x" * 1000 + "'/>" + "".join(
            f"<default name='{b}' value='{('$' + a) * 50}'/>" for a, b in ("ab", "bc", "cd")) + "</scene>",
         "more than 100,000 letters"),
        ("<scene><bsdf type='twosided' id='a'><ref id='a'/></bsdf><shape type='cube'><ref id='a'/></shape></scene>",
         "does one hold itself?"),
        (b"\x00\x01\x02", "broken XML"),
        ("<scene/>", "no shape in it"),
    ],
)  # fmt: skip
def test_hostile_files_are_refused_by_line(read, text, said):
    with pytest.raises(SceneError, match="scene.xml") as error:
        read(text)
    assert said in str(error.value)
