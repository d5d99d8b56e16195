"""What `explain` says a picture costs: counts against what was traced, and each effect against the picture without
it.
"""

import dataclasses
import functools

import numpy as np
import pytest
from mesh_samples import ball

import diffwhitted as dw
from diffwhitted.cost._effects import picture_cost
from diffwhitted.cost._work import Work, work_of, work_programs
from diffwhitted.tree import make_plan
from fitting.command_line._explain import print_explanation

SKY = (0.2, 0.4, 0.8)


@functools.cache
def scene():
    """A mirror and a glass ball over a floor."""
    objects = [
        dw.Sphere("ball", (0.7, 0, 0), 0.6, "glass"),
        dw.Sphere("mirror", (-0.7, 0, 0), 0.6, "mirror"),
        dw.Plane("ground", (0, 1, 0), -1, "floor"),
    ]
    materials = {
        "glass": dw.Material(k_s=0.2, k_t=0.8, k_h=0, refractive_index=1.5),
        "mirror": dw.Material(k_s=0.9, k_h=0),
        "floor": dw.Material(k_d=0.6, k_h=0),
    }
    return dw.Scene(
        objects=objects,
        materials=materials,
        lights=[dw.PointLight((2, 4, 3), 1)],
        background=dw.ConstantBackground(SKY),
        max_depth=4,
        cameras={"main": dw.Camera((0, 0.3, 4), (0, 0, 0), 45, 32, 24)},
    )


def test_maps_add_up_to_the_counts():
    camera = scene().cameras["main"]
    maps, counts = dw.ray_maps(scene(), camera), dw.explain(scene(), camera, measure=False).rays
    assert maps.rays.shape == maps.depth.shape == maps.squares.shape == (24, 32)
    assert maps.rays.sum() == counts.total and maps.rays.min() == 1
    assert [(maps.depth >= level).sum() > 0 for level in range(1, 6)] == [True] * 4 + [False]
    assert maps.depth.max() == len(counts.by_level)
    np.testing.assert_array_equal(maps.squares, dw.antialias(scene(), camera, 0.1).squares)


def test_maps_show_where_things_are():
    """The sky is one ray, the mirror two where it shows the sky, and the middle of the glass a tree of all levels."""
    maps = dw.ray_maps(scene(), scene().cameras["main"], max_depth=3)
    assert maps.rays[1, 1] == maps.depth[1, 1] == 1
    assert maps.rays[9, 8] == maps.depth[9, 8] == 2
    assert (
        maps.depth[12, 23] == 3 and maps.rays[12, 23] == 5
    )  # the ray, its two children, and of the one inside two again


def test_an_effect_is_measured_against_the_picture_without_it():
    camera, said = scene().cameras["main"], []
    cost = picture_cost(scene(), camera, make_plan(scene(), camera, capacity=5 * 32 * 24), ["refraction"], said.append)
    counts = dw.explain(scene(), camera, measure=False).rays
    assert cost.rays == counts.total
    assert (
        cost.effects["refraction"].rays > counts.by_kind["transmitted"] and said[1] == "the picture without refraction"
    )
    assert cost.effects["refraction"].compile_share < 1 and cost.seconds > 0


def test_the_parts_of_the_work_are_told_from_three_times():
    """Of 8 ms the search takes 6, of which 1 is the way along its rays; a round that was disturbed does not count."""
    whole, search, walk = 8e-3 * np.ones(5), 6e-3 * np.ones(5), 1e-3 * np.ones(5)
    whole[2], search[4] = 1.0, 0.5
    assert work_of(whole, search, walk) == Work(
        overhead=pytest.approx(1 / 8), intersection=pytest.approx(5 / 8), shading=pytest.approx(2 / 8)
    )


def test_the_parts_are_those_of_all_trees_of_a_pixel():
    """2 x 2 of them."""
    ball = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "paint")],
        materials={"paint": dw.Material(k_a=0.5, k_h=0)},
        footprint=2,
        cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 40, 8, 6)},
    )
    plan = make_plan(ball, ball.cameras["main"], capacity=4 * 8 * 6)
    parts = work_programs(ball, ball.cameras["main"], plan)
    assert [trees.descendants.shape for trees in parts["search"].run()] == [(4,)]
    assert [points.shape for points in parts["walk"].run()] == [(4, 3, plan.pass_pixels)]


def test_explain_says_what_a_ray_of_each_kind_tests(capsys):
    """Of a ball of 320 triangles, a tree of nine levels, over a plane that has none: each search asks the plane too."""
    vertices, faces = ball(2)
    things = [dw.Mesh("ball", vertices, faces, "mirror"), dw.Plane("ground", (0, 1, 0), -1, "floor")]
    one = dw.Scene(
        objects=things,
        materials={"mirror": dw.Material(k_s=0.9, k_h=0), "floor": dw.Material(k_d=0.6, k_h=0)},
        lights=[dw.PointLight((2, 4, 3), 1)],
        cameras={"main": dw.Camera((0, 0.3, 4), (0, 0, 0), 45, 32, 24)},
        max_depth=2,
    )
    found = dw.explain(one, one.cameras["main"], measure=False)
    assert (
        list(found.search) == ["camera", "mirror", "shadow"]
        and not dw.explain(scene(), scene().cameras["main"], measure=False).search
    )
    counts = {**found.rays.by_kind, "shadow": found.rays.shadow}
    assert all(abs(tests.counted - counts[kind]) <= 2 for kind, tests in found.search.items())
    # A ray that meets the ball goes down nine levels, and looks into two boxes at each; few need less than one surface.
    assert 1 < found.search["camera"].boxes < 2 * 9 + 10 and 1 < found.search["camera"].surfaces < 4
    assert found.to_json()["search"]["mirror"] == dataclasses.asdict(found.search["mirror"])
    print_explanation(found, "ball")
    said = capsys.readouterr().out
    assert "tests of a ray" in said and f"{found.search['shadow'].boxes:.1f}" in said
    assert max(map(len, said.splitlines())) <= 80
