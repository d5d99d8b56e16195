"""Standard scenes: how much is in them, rays counted against a counter of its own, files that hold the same."""

import jax
import numpy as np
import pytest

import diffwhitted as dw
from benchmarks.spd import count_rays
from diffwhitted.formats import with_files
from diffwhitted.standard import STANDARD, exponent_of, view_angle
from diffwhitted.standard._balls import around_z, flake
from diffwhitted.standard._gears import gear
from diffwhitted.standard._mount import ball_centres, normal_number
from diffwhitted.standard._rings import pentagons
from diffwhitted.standard._teapot import control_points, patch_grid, pot
from diffwhitted.standard._tree import branches
from fitting.command_line import main

SMALL = {"balls": 1, "gears": 2, "mount": 2, "rings": 2, "teapot": 3, "tetra": 2, "tree": 3, "table": 12}
"""Sizes for tests; the others have their usual one."""


def small(name: str) -> dw.Scene:
    return dw.standard_scene(name, SMALL.get(name))


# What is in them.


@pytest.mark.parametrize(
    ("name", "size", "surfaces"),
    [
        ("balls", 4, 7381 + 1),
        ("mount", 6, 8192 + 4),
        ("tetra", 6, 4096),
        ("rings", 2, 5 * 60 + 1),
        ("tree", 5, 2 * 63 + 1),
        ("teapot", 12, 9120 + 2 * 144),
        # Of each gear 146 polygons: two of 142 triangles, 144 of two.
        ("gears", 2, 8 * (2 * 142 + 2 * 144) + 1),
    ],
)
def test_the_primitives_are_as_many_as_published(name, size, surfaces):
    scene = dw.standard_scene(name, size)
    assert sum(thing.surfaces for thing in scene.objects) == surfaces


def test_the_usual_sizes_are_those_of_the_databases():
    """7381 + 1, 9345, 8196, 8401, 8191 and 9264 primitives, by the formulas of each."""
    sizes = {name: entry.size for name, entry in STANDARD.items()}
    assert (9 ** (sizes["balls"] + 1) - 1) // 8 + 1 == 7382
    assert sizes["gears"] ** 3 * 146 + 1 == 9345
    assert 2 * 4 ** sizes["mount"] + 4 == 8196
    assert 60 * sum((d + 1) ** 2 for d in range(sizes["rings"])) + 1 == 8401
    assert 2 * (2 ** (sizes["tree"] + 1) - 1) + 1 == 8191
    assert len(pot(sizes["teapot"])[2]) + sizes["teapot"] ** 2 == 9264
    assert 4 ** sizes["tetra"] == 4096


def test_each_ball_touches_its_parent_and_none_of_its_sisters_lies_in_it():
    centres, radii = flake(2)
    parents = np.repeat(np.arange(10), 9)
    apart = np.linalg.norm(centres[1:] - centres[parents], axis=1)
    np.testing.assert_allclose(apart, radii[1:] + radii[parents], rtol=1e-12)
    ways = around_z()
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1, rtol=1e-12)
    # Six about the equator in steps of 60 degrees, three above in steps of 120 degrees.
    level = np.sort(ways[:, 2])
    np.testing.assert_allclose(level[:6], 0, atol=1e-12)
    np.testing.assert_allclose(level[6:], np.sqrt(2 / 3), rtol=1e-12)
    # Seen from the way of a parent, its children stand as those of the root about +z.
    own = (centres[1:10] - centres[0]) / np.linalg.norm(centres[1:10] - centres[0], axis=1, keepdims=True)
    inner = (centres[10:] - centres[parents[9:]]).reshape(9, 9, 3)
    inner /= np.linalg.norm(inner, axis=-1, keepdims=True)
    seen = np.sort(np.einsum("pck,pk->pc", inner, own), axis=1)
    np.testing.assert_allclose(seen, np.broadcast_to(level, (9, 9)), atol=1e-9)


def test_the_glass_balls_touch_each_other():
    centres = ball_centres()
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=-1)
    np.testing.assert_allclose(apart[~np.eye(4, dtype=bool)], 2 * 0.17, rtol=1e-12)
    np.testing.assert_allclose(centres.mean(axis=0), (-0.8, 0.8, 1.0), atol=1e-12)


def test_random_numbers_of_the_mountain_are_normal():
    numbers = np.asarray([normal_number(i, j) for i in range(40) for j in range(40)])
    assert abs(numbers.mean()) < 0.1 and numbers.std() == pytest.approx(1, abs=0.1)


def test_the_rings_are_regular_and_share_a_middle():
    rings = pentagons()
    sides = np.linalg.norm(rings - np.roll(rings, 1, axis=1), axis=-1)
    np.testing.assert_allclose(sides, sides[0, 0], rtol=1e-12)
    np.testing.assert_allclose(rings.mean(axis=1), 0, atol=1e-12)
    normals = np.cross(rings[:, 0], rings[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    # The six axes through the corners of an icosahedron: any two at the same angle, cos = 1 / sqrt(5).
    cosines = abs(normals @ normals.T)[~np.eye(6, dtype=bool)]
    np.testing.assert_allclose(cosines, 1 / np.sqrt(5), rtol=1e-12)


def test_gears_are_closed_and_teeth_meet_between_two():
    vertices, faces = gear(0.4, 0.36, 0.1, 0.0)
    mesh = dw.Mesh("gear", vertices, faces, "a")
    assert mesh.closed and not mesh.inside_out
    # By the shoelace formula on the rim.
    x, y, _ = vertices[:144].T
    area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(area * 0.1, rel=1e-12)


def test_branches_grow_as_their_parents_say():
    grown = list(branches(2))
    assert len(grown) == 7
    (_, tip, radius), first, second = grown[0], grown[1], grown[2]
    np.testing.assert_allclose(tip, (0, 0, 1))
    # +z turned by 40 degrees about x goes to -y, then by 90 about z to +x.
    np.testing.assert_allclose(
        first[1] - first[0], 0.65 * np.asarray([np.sin(np.radians(40)), 0, np.cos(np.radians(40))]), atol=1e-12
    )
    assert np.linalg.norm(second[1] - second[0]) == pytest.approx(0.7) and second[2] == pytest.approx(0.67 * radius)
    np.testing.assert_array_equal(second[0], tip)


def test_normals_of_the_teapot_are_those_of_its_patches():
    """Against differences of points nearby; at the collapsed sides of lid and bottom they are along the axis."""
    control = control_points()
    at, step = np.asarray([0.3, 0.7]), 1e-6
    points, normals = patch_grid(control, at)
    further = patch_grid(control, at + step)[0]
    # S(s + d, t + d) - S(s, t) lies in the surface.
    along = (further - points)[:, [0, 1], [0, 1]]
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    assert abs((along * normals[:, [0, 1], [0, 1]]).sum(axis=-1)).max() < 1e-4
    _, ends = patch_grid(control, np.asarray([0.0, 1.0]))
    np.testing.assert_allclose(ends[20:24, 0], np.broadcast_to([0, 0, 1], (4, 2, 3)), atol=1e-9)
    np.testing.assert_allclose(ends[28:, 0], np.broadcast_to([0, 0, -1], (4, 2, 3)), atol=1e-9)
    # Triangles and normals look to the same side.
    vertices, normals, faces = pot(6)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a) * normals[faces].mean(axis=1)).sum(axis=-1).min() > 0


def test_rules_of_the_databases():
    assert exponent_of(37) == pytest.approx(3.08, abs=0.005) and exponent_of(6.7) == pytest.approx(101, abs=0.6)
    assert exponent_of(30) == pytest.approx(4.82, abs=0.005)
    camera = small("tetra").cameras["main"]
    corner = camera.rays(np.asarray([256.0]), np.asarray([0.5])).direction
    middle = camera.rays(np.asarray([256.0]), np.asarray([256.0])).direction
    cosine = sum(float(getattr(corner, axis)[0]) * float(getattr(middle, axis)[0]) for axis in "xyz")
    assert np.degrees(np.arccos(cosine)) == pytest.approx(22.5, abs=1e-3) and view_angle(45, 1) == pytest.approx(45)
    lights = small("balls").lights
    np.testing.assert_allclose([light.colour for light in lights], np.sqrt(3) / 6, rtol=1e-6)


# Rays, counted.


def brute_force(scene: dw.Scene, corners: int, depth: int) -> dict[str, int]:
    """Haines' protocol for spheres and one square floor at z = -0.5, all opaque, one ray after the other, float64."""
    flake, floor = scene.objects
    centres, radii = np.asarray(flake.centres, np.float64), np.asarray(flake.radii, np.float64)
    eye = np.asarray([2.1, 1.3, 1.7])
    ahead = -eye / np.linalg.norm(eye)
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    # The camera of 512 rows that is made smaller keeps its angle.
    half = np.tan(np.radians(22.5)) * 512 / 511
    mirrors = {"flake": True, "floor": False}
    counts: dict[str, int] = dict.fromkeys(("eye", "reflected", "refracted", "shadow"), 0)

    def hit(origin, way, but):
        best, found = np.inf, None
        for k, (centre, radius) in enumerate(zip(centres, radii, strict=True)):
            to = centre - origin
            along = to @ way
            root = radius**2 - to @ to + along**2
            if k != but and root > 0 and 0 < along - np.sqrt(root) < best:
                best = along - np.sqrt(root)
                point = origin + best * way
                found = point, (point - centre) / radius, "flake", k
        if way[2] < 0 and but != "floor" and 0 < (distance := (-0.5 - origin[2]) / way[2]) < best:
            point = origin + distance * way
            if abs(point[:2]).max() < 12:
                found = point, np.asarray([0.0, 0, 1]), "floor", "floor"
        return found

    def follow(origin, way, level, but):
        found = hit(origin, way, but)
        if found is None:
            return
        point, normal, what, number = found
        counts["eye"] += level == 1
        counts["shadow"] += sum((np.asarray(light.position) - point) @ normal > 0 for light in scene.lights)
        if mirrors[what] and level < depth:
            counts["reflected"] += 1
            follow(point, way - 2 * (way @ normal) * normal, level + 1, number)

    for row in range(corners):
        for column in range(corners):
            across, up = (2 * column / (corners - 1) - 1) * half, (1 - 2 * row / (corners - 1)) * half
            way = ahead + across * right + up * np.cross(right, ahead)
            follow(eye, way / np.linalg.norm(way), 1, None)
    return counts


def test_rays_are_counted_as_brute_force_counts_them():
    scene = dw.standard_scene("balls", 1)
    ours, theirs = count_rays(scene, corners=17, depth=4), brute_force(scene, 17, 4)
    assert theirs["eye"] == 289 and theirs["reflected"] > 60
    for kind, count in theirs.items():
        assert abs(ours[kind] - count) <= 2, (kind, ours, theirs)


def test_each_hit_on_glass_sends_both_rays_but_at_total_reflection():
    """Of the mountain's balls: past the first level a refracted ray is inside, and meets a surface again."""
    found = count_rays(dw.standard_scene("mount", 1), corners=33, depth=3)
    assert found["reflected"] >= found["refracted"] > 0
    once = count_rays(dw.standard_scene("mount", 1), corners=33, depth=2)
    assert once["reflected"] == once["refracted"] < found["refracted"]


# By name, and as files.


@pytest.mark.parametrize("name", STANDARD)
def test_a_scene_is_made_by_name_and_its_files_hold_the_same(name, tmp_path):
    scene, path = small(name), tmp_path / "scene.toml"
    written, files = with_files(scene, path)
    for place, data in files.items():
        place.write_bytes(data)
    dw.save_scene(written, path)
    again = dw.load_scene(path)
    assert list(again.materials) == list(scene.materials)
    for one, other in zip(scene.objects, again.objects, strict=True):
        assert (one.name, one.material) == (other.name, other.material)
        for mine, theirs in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True):
            np.testing.assert_array_equal(np.asarray(mine), np.asarray(theirs))
    assert "file" in path.read_text() or not files


@pytest.mark.parametrize(
    ("name", "size", "said"),
    [
        ("bals", None, "no standard scene is called 'bals'; .* Did you mean 'balls'?"),
        ("balls", 0, "size = 0; allowed is a whole number from 1 to 6, usual is 4"),
        ("tetra", 11, "from 1 to 10"),
        ("tree", 2.0, "size = 2.0"),
    ],
)
def test_what_is_no_scene_is_refused(name, size, said):
    with pytest.raises(dw.SceneError, match=said):
        dw.standard_scene(name, size)


def test_the_command_writes_scenes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["scene", "--list"]) == 0
    heard = capsys.readouterr().out
    assert [line.split()[0] for line in heard.splitlines()] == list(STANDARD)
    assert main(["scene", "mount", "--size", "3", "-o", "hill.toml"]) == 0
    assert capsys.readouterr().out == ("wrote hill.toml, and beside it hill_mountain.ply: 2 objects of 132 surfaces\n")
    assert 'file = "hill_mountain.ply"' in (tmp_path / "hill.toml").read_text()
    assert len(dw.load_scene("hill.toml").objects[0].faces) == 128
    for arguments, said in (
        ([], "NAME of a scene is missing"),
        (["bals"], "'balls'"),
        (["tree", "-o", "a.obj"], ".toml"),
    ):
        assert main(["scene", *arguments]) == 2
        assert said in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hill.toml", "hill_mountain.ply"]
