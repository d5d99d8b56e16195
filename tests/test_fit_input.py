"""What is given to a fit: targets by camera, names with wildcards' characters, options out of range."""

import numpy as np
import pytest

import fitting
from diffwhitted import Camera, DirectionalLight, InputError, Material, Scene, Sphere, render
from fitting import FitError, Target
from fitting.problem._free_names import free_parameters
from fitting.problem._target import as_targets
from fitting.problem._unknowns import list_unknowns, start_values


def scene_of(name: str = "m", **coefficients) -> Scene:
    """A matte ball of a material of that name, seen by two cameras."""
    return Scene(
        objects=[Sphere("ball", (0, 0, 0), 1, name)],
        materials={name: Material(**({"k_d": 0.5} | coefficients))},
        lights=[DirectionalLight((0.3, 0.5, 1), (1, 1, 1))],
        cameras={"main": Camera((0, 0, 5), (0, 0, 0), 40, 16, 12), "right": Camera((5, 0, 0), (0, 0, 0), 40, 16, 12)},
    )


def picture(scene: Scene, camera: str = "main") -> np.ndarray:
    return np.asarray(render(scene, scene.cameras[camera]))


def test_a_target_in_a_mapping_belongs_to_the_camera_of_its_key():
    targets = as_targets(
        scene_of(), {"right": Target(picture(scene_of(), "right")), "main": Target(picture(scene_of()), "main")}
    )
    assert [t.camera for t in targets] == ["right", "main"]


def test_a_target_that_contradicts_its_key_is_refused():
    with pytest.raises(FitError, match="'right' names the camera 'main'"):
        as_targets(scene_of(), {"right": Target(picture(scene_of()), "main")})


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, int, bool, complex])
def test_codes_are_no_light(dtype):
    with pytest.raises(FitError, match="8-bit codes.*read_image"):
        as_targets(scene_of(), np.ones((12, 16, 3), dtype))


@pytest.mark.parametrize("name", ["paint [matte]", "a*", "why?", "[x].1"])
def test_a_material_s_name_may_hold_the_characters_of_wildcards(name):
    scene, full = scene_of(name), f"{name}.k_d"
    assert free_parameters(scene, [full])[0] == (full,)
    unknowns = list_unknowns(scene, [full], {full: (0.2, 0.9)})
    assert unknowns[0].bounds == (0.2, 0.9)
    assert start_values(scene, unknowns, {full: 0.3}).tolist() == [0.3]


def test_a_plain_name_with_a_star_is_that_name_alone():
    scene = Scene(
        objects=[Sphere("s", (0, 0, 0), 1, "a*"), Sphere("t", (3, 0, 0), 1, "ab")],
        materials={"a*": Material(k_d=0.5), "ab": Material(k_d=0.5)},
        lights=[DirectionalLight((0, 0, 1), 1)],
    )
    assert free_parameters(scene, ["a*.k_d"])[0] == ("a*.k_d",)


@pytest.mark.parametrize(
    "options, words",
    [
        ({"samples": 0}, ["samples = 0", "1 or more"]),
        ({"samples": 1.5}, ["samples = 1.5", "whole number"]),
        ({"max_steps": 0}, ["max_steps = 0", "1 or more"]),
        ({"max_depth": 0}, ["max_depth = 0", "1", "64"]),
        ({"max_depth": 65}, ["max_depth = 65", "1", "64"]),
        ({"max_depth": True}, ["max_depth = True", "whole number"]),
        ({"starts": True}, ["starts = True", "whole number"]),
        ({"starts": "3"}, ["starts = '3'", "whole number"]),
        ({"bounds": {"m.k_d": 0.5}}, ["bounds: m.k_d = 0.5", "(low, high)"]),
        ({"bounds": {"m.k_d": ("a", "b")}}, ["bounds: m.k_d", "(low, high)"]),
        ({"start": {"m.k_d": "x"}}, ["start: m.k_d = 'x'", "a number"]),
        ({"start": {"m.k_d": float("nan")}}, ["start: m.k_d = nan"]),
        ({"start": {"m.k_d": [0.1, 0.2]}}, ["start: m.k_d = [0.1, 0.2]", "a number"]),
    ],
)
def test_an_option_out_of_range_is_one_sentence(options, words):
    with pytest.raises(InputError) as caught:
        fitting.fit(scene_of(), picture(scene_of()), ["m.k_d"], **options)
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_whole_numbers_of_numpy_are_whole_numbers():
    result = fitting.fit(
        scene_of(k_d=0.3),
        picture(scene_of()),
        ["m.k_d"],
        samples=np.int64(1),
        max_depth=np.int32(2),
        max_steps=np.int8(20),
    )
    assert result["m.k_d"].value == pytest.approx(0.5, abs=1e-4)
