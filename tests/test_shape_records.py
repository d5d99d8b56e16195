"""Records of shapes: their numbers and derivatives, transforms, files, what is refused, and their triangles."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED
from shape_samples import CORNERS, STAIRS, THINGS, random_rays, rays

import diffwhitted as dw
from diffwhitted import SceneError
from diffwhitted.formats._meshes import MESHES
from diffwhitted.formats.toml import scene_text
from diffwhitted.scene import OBJECTS

POSED = {
    **{name: THINGS[name].placed(translate=(0.1, -0.2, 0.05), rotate_deg=(7, -4, 11), scale=1.1)
       for name in ("disc", "box", "tube", "cone", "bucket", "saddle", "torus", "prism")},
    "ball": dw.Sphere("thing", (0.2, 0.1, 0), 0.8, "m").placed(
        scale=0.9, rotate_deg=(10, 0, 5), translate=(0, 0.1, 0)),
    "ground": dw.Plane("thing", (0.1, 2, 0.3), 0.2, "m").placed(
        scale=2.0, rotate_deg=(10, 0, 5), translate=(0, 0.1, 0)),
    "egg": THINGS["ellipsoid"].placed(scale=(1, 0.8, 1.2), rotate_deg=(10, 20, 5)),
    "sheet": dw.Polygon("thing", [(-1, 0, -1), (0, 0, 1.5), (1.2, 0, -1)], "m").placed(
        scale=(1, 1, 1.3), rotate_deg=(80, 0, 5)),
}  # fmt: skip
COUNT = 8


def test_every_kind_of_object_is_asked():
    """Those of many surfaces in `test_meshes`."""
    assert {type(thing) for thing in POSED.values()} == set(OBJECTS) - {dw.Mesh, dw.Patch, dw.SphereSet}


@pytest.mark.parametrize("name", POSED)
def test_derivatives_in_every_number(name):
    """Of where rays meet it, against central differences, in what it is and in where it is placed; forward against
    reverse.
    """
    thing = POSED[name]
    origins, ways = random_rays(7, 40)
    member = jax.tree.map(lambda a: a[0], thing.as_placed().alone())
    ahead = np.stack(member.crossings(rays(origins, ways), jnp.zeros(40, bool), jnp.zeros(40, bool)))
    met = np.flatnonzero(np.isfinite(ahead).any(axis=0))[:COUNT]
    ray, crossing = rays(origins[met], ways[met]), jnp.asarray(ahead[:, met].argmin(axis=0), jnp.int8)
    assert len(met) > 2

    def seen(thing):
        member = jax.tree.map(lambda a: a[0], thing.as_placed().alone())
        distance, normal, point, _ = member.carrier().surface(ray, crossing)
        return jnp.stack([distance, *(c + 0 * distance for v in (normal, point) for c in (v.x, v.y, v.z))])

    leaves, rest = jax.tree.flatten(thing)
    soon = functools.partial(jax.jit, compiler_options=SOON_COMPILED)
    hits, slopes = soon(seen), soon(jax.jacfwd(seen))(thing)
    weights = np.random.default_rng(1).normal(size=(7, len(met)))
    backward = soon(jax.grad(lambda thing: (seen(thing) * weights).sum()))(thing)
    moves = 0
    for k, (leaf, slope, back) in enumerate(
        zip(leaves, jax.tree.leaves(slopes), jax.tree.leaves(backward), strict=True)
    ):
        assert np.isfinite(slope).all() and np.isfinite(back).all()
        for index in np.ndindex(np.shape(leaf)):
            ends = []
            for step in (1e-6, -1e-6):
                other = np.array(leaf)
                other[index] += step
                ends.append(np.asarray(hits(jax.tree.unflatten(rest, [*leaves[:k], other, *leaves[k + 1 :]]))))
            central = (ends[0] - ends[1]) / 2e-6
            np.testing.assert_allclose(np.asarray(slope)[(..., *index)], central, rtol=2e-5, atol=1e-6)
            assert float(np.asarray(back)[index]) == pytest.approx(float((weights * central).sum()), rel=2e-5, abs=1e-5)
            moves += bool(abs(central).max() > 1e-3)
    assert moves >= 6


def test_names_of_numbers():
    scene = dw.Scene(objects=[POSED["torus"], dw.Quadric("egg", [1] * 3 + [0] * 6 + [-1], "m")],
                     materials={"m": dw.Material()})  # fmt: skip
    names = [p.name for p in dw.parameters(scene)]
    for name in ("object.thing.minor_radius", "object.thing.scale", "object.thing.translate", "object.thing.rotate_deg",
                 "object.egg.coefficients"):  # fmt: skip
        assert name in names
    assert "object.egg.scale" not in names
    wider = dw.replace_parameter(scene, "object.thing.minor_radius", 0.4)
    assert float(wider.objects[0].minor_radius) == pytest.approx(0.4) and wider.objects[0].scale is not None
    assert float(dw.parameter_value(scene, "object.egg.coefficients.1")) == -1
    with pytest.raises(SceneError, match="states no scale; write one in the scene"):
        dw.parameter_value(scene, "object.egg.scale")
    with pytest.raises(SceneError, match="minor_radius = 0.9; allowed is less than major_radius = 0.8"):
        dw.replace_parameter(scene, "object.thing.minor_radius", 0.9)


# Transforms


def test_scale_then_turns_then_shift_by_hand():
    """A quarter turn about x takes y to z, then one about y takes z to x."""
    placed = dw.Sphere("s", (0, 1, 0), 0.5, "m").placed(translate=(10, 0, 0), rotate_deg=(90, 90, 0), scale=2)
    there = placed.as_placed()
    np.testing.assert_allclose(there.centre, (12, 0, 0), atol=1e-12)
    assert float(there.radius) == 1 and there.scale is None and there.translate is None
    matrix = [[0, 2, 0, 10], [0, 0, 2, 0], [2, 0, 0, 0], [0, 0, 0, 1]]
    other = dw.Sphere("s", (0, 1, 0), 0.5, "m").placed(matrix=matrix).as_placed()
    np.testing.assert_allclose(other.centre, (12, 0, 0), atol=1e-12)
    assert float(other.radius) == pytest.approx(1)


@pytest.mark.parametrize("name", ["ball", "ground", "box", "bucket", "egg", "torus", "prism"])
def test_what_is_inside_goes_along(name):
    """A point is in it where the point that is taken there was in it before."""
    thing = POSED[name]
    bare = eqx.tree_at(lambda t: (t.scale, t.rotate_deg, t.translate), thing, (None,) * 3, is_leaf=lambda x: x is None)
    angles = np.radians(thing.rotate_deg)
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    turn = np.asarray([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]) @ np.asarray([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    linear = turn @ np.asarray([[1, 0, 0], [0, cx, -sx], [0, sx, cx]]) @ np.diag(np.ones(3) * np.asarray(thing.scale))
    points = np.random.default_rng(3).uniform(-1.2, 1.2, (40, 3))
    before = [bare.holds(p) for p in points]
    shift = np.zeros(3) if thing.translate is None else np.asarray(thing.translate)
    assert [thing.as_placed().holds(linear @ p + shift) for p in points] == before and 0 < sum(before) < 40
    far = thing.as_placed().moved(np.asarray([1e5, -2e5, 3e5]))
    assert [far.holds(linear @ p + shift + [1e5, -2e5, 3e5]) for p in points] == before


FAULTS = {
    "disc": [(dict(radius=0), "radius = 0; allowed is > 0"), (dict(normal=(0, 0, 0)), "any vector but zero")],
    "box": [(dict(minimum=(2, 0, 0)), "allowed is a minimum below maximum in x, y and z"),
            (dict(minimum=(np.nan, 0, 0)), "not finite")],
    "cylinder": [(dict(top=(-0.2, -0.8, 0.1)), "is base; allowed is any other point"),
                 (dict(radius=None), "allowed is radius, or base_radius and top_radius in its place; neither"),
                 (dict(base_radius=1), "both are stated"),
                 (dict(radius=None, base_radius=1, top_radius=2), 'For two, use type = "cone"'),
                 (dict(capped=1), "capped = 1; allowed is true or false")],
    "cone": [(dict(base_radius=0), "both 0; allowed is 0 for one of them"), (dict(base_radius=-1), "allowed is >= 0")],
    "ellipsoid": [(dict(coefficients=[0] * 9 + [1]), "one other than 0 among the first nine"),
                  (dict(coefficients=[1] * 9), "allowed is 10 numbers"),
                  (dict(minimum=(0, 0, 0)), "allowed are both or neither")],
    "torus": [(dict(minor_radius=0.8), "minor_radius = 0.8; allowed is less than major_radius = 0.8"),
              (dict(axis=(0, 0, 0)), "any vector but zero"), (dict(minor_radius=0), "allowed is > 0")],
    "prism": [(dict(faces=STAIRS[1:]), "so it is open there"), (dict(faces=[STAIRS[0], *STAIRS]), "2 faces run from"),
              (dict(faces=[f[::-1] for f in STAIRS]), "run clockwise seen from outside"),
              (dict(faces=[(0, 1), *STAIRS]), "entry 0 has 2 corners"),
              (dict(faces=STAIRS[:3]), "allowed is from 4 to"),
              (dict(faces=[(0, 2, 99), *STAIRS]), "face 0 has corner 99; allowed is from 0 to 11"),
              (dict(faces=3), "is not a list of lists of whole numbers"),
              (dict(vertices=[(0, 0, 0.4), *CORNERS[1:]]), "face 0 is not flat")],
}  # fmt: skip


@pytest.mark.parametrize("name, wrong, said", [(n, w, s) for n, cases in FAULTS.items() for w, s in cases])
def test_what_is_not_allowed_is_a_sentence(name, wrong, said):
    thing = THINGS[name]
    own = [row.name for row in thing.ROWS if row.name not in ("scale", "rotate_deg", "translate", "matrix")]
    stated = {key: getattr(thing, key) for key in own if getattr(thing, key) is not None}
    with pytest.raises(SceneError, match="^object 'odd': ") as error:
        type(thing)("odd", material="m", **{**stated, **wrong})
    assert said in str(error.value)


@pytest.mark.parametrize(
    "pose, said",
    [
        (dict(scale=(1, 2, 1)), "scale = [1, 2, 1] is not the same along all axes"),
        (dict(scale=0), "scale = 0; allowed is > 0"),
        (dict(translate=(0, np.inf, 0)), "not finite"),
        (dict(matrix=np.eye(3)), "matrix has shape (3, 3); allowed is shape (4, 4)"),
        (dict(matrix=np.diag([1, 1, -1, 1])), "mirrors it"),
        (dict(matrix=np.diag([1, 1, 1, 2])), "allowed is [0, 0, 0, 1]"),
        (dict(matrix=np.diag([1, 2, 1, 1])), 'For an ellipsoid, use type = "quadric"'),
        (dict(matrix=np.eye(4), scale=2), "matrix and scale are stated"),
    ],
)
def test_a_transform_that_is_not_allowed_is_a_sentence(pose, said):
    with pytest.raises(SceneError, match="^object 'ball': ") as error:
        dw.Sphere("ball", (0, 0, 0), 1, "m").placed(**pose)
    assert said in str(error.value)


def test_files_give_back_the_same_scene():
    things = {**{f"{name} as it is": thing for name, thing in THINGS.items()}, **POSED}
    matrix = [[0, 2, 0, 1], [0, 0, 2, 2], [2, 0, 0, 3.5], [0, 0, 0, 1]]
    things["moved"] = dw.Sphere("b", (0, 0, 0), 1, "m").placed(matrix=matrix)
    for thing in things.values():
        scene = dw.Scene(objects=[thing], materials={"m": dw.Material(k_d=0.5)})
        text = scene_text(scene)
        again = dw.parse_scene(text)
        assert eqx.tree_equal(again, scene)


def test_a_cylinder_may_state_the_radius_of_both_ends():
    text = """
[[material]]
name = "m"
[[object]]
name = "c"
type = "cylinder"
base = [0, 0, 0]
top = [0, 1, 0]
base_radius = 0.5
top_radius = 0.5
capped = false
translate = [0, 1, 0]
material = "m"
"""
    (thing,) = dw.parse_scene(text).objects
    assert float(thing.radius) == 0.5 and thing.capped is False and thing.as_placed().top.tolist() == [0, 2, 0]
    for line, said in (("capped = 1", "capped"), ("scale = [1, 2]", "scale"), ("matrix = [[1]]", "matrix"),
                       ("scale = -1", "scale = -1")):  # fmt: skip
        with pytest.raises(SceneError, match=said):
            dw.parse_scene(text.replace("capped = false", line))


VOLUMES = {
    "box": 1.6 * 1.4 * 1.5,
    "cylinder": np.pi * 0.36 * np.linalg.norm([0.5, 1.7, -0.3]),
    "cone": np.pi * 0.27 * np.linalg.norm([0.5, 1.7, -0.3]),
    "bucket": np.pi * (0.09 + 0.24 + 0.64) / 3 * np.linalg.norm([0.5, 1.7, -0.3]),
    "torus": 2 * np.pi**2 * 0.8 * 0.09,
    "prism": 3.0,
}


@pytest.mark.parametrize("name", VOLUMES)
def test_triangles_of_a_solid_close_its_volume_outwards(name):
    thing = THINGS[name].as_placed()
    points, normals, triangles = MESHES[type(thing)](thing, np.zeros(3), 1.0)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = (a * np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(VOLUMES[name], rel=0.02)
    assert (np.cross(b - a, c - a) * normals[triangles].mean(axis=1)).sum(axis=1).min() > 0
