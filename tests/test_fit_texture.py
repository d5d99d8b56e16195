"""The fit of a texture: texels found from pictures, standard errors against a dense inverse, what is not seen."""

import json
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import sparse

import diffwhitted as dw
from fitting import FitError, Target, fit_texture
from fitting.command_line import main
from fitting.judging._banded import Banded
from fitting.judging._map_rows import _nearest, _stripes, map_rows
from fitting.solving import _map_solve

SIZE = (8, 8)
TRUE = np.random.default_rng(8).uniform(0.2, 0.9, (*SIZE, 3))
SMALL = (24, 18)
NOISE = 1e-3


def room(texels=TRUE, mirror=0.0, precision="float64", file=None, footprint=0):
    """A wall with the map, a ball before it, a floor that may be a mirror and show the map itself; two cameras."""
    return dw.Scene(
        objects=[
            dw.Polygon("wall", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], "paint"),
            dw.Sphere("ball", (0.5, 0.3, 0.8), 0.3, "plain"),
            dw.Plane("floor", (0, 1, 0), -0.6 if mirror else -1, "glossy"),
        ],
        materials={
            "paint": dw.Material(k_d=0.9, k_a=0.05, k_h=0, k_d_texture="map"),
            "plain": dw.Material(k_d=0.3, k_a=0.1, k_h=0),
            "glossy": dw.Material(k_d=0.2, k_a=0.1, k_h=0, k_s=mirror, k_d_texture="map" if mirror else None),
        },
        lights=[dw.PointLight((1, 2, 4), 1.0), dw.PointLight((-2, 1, 4), (0.5, 0.4, 0.3))],
        textures={"map": dw.ImageTexture(texels, mapping="planar", origin=(-1, -1, 0), edge_u=(2, 0, 0),
                                         edge_v=(0, 2, 0), wrap="clamp", file=file)},
        cameras={
            name: dw.Camera(place, (0, 0, 0), 45, *SMALL)
            for name, place in (("left", (-1, 0, 2.5)), ("right", (1.2, 0, 2.2)))
        },
        max_depth=2,
        precision=precision,
        footprint=footprint,
    )  # fmt: skip


def pictures(scene, noise=0.0, cameras=("left", "right")):
    random = np.random.default_rng(1)
    return {
        name: np.asarray(dw.render(scene, scene.cameras[name])) + noise * random.normal(size=(*SMALL[::-1], 3))
        for name in cameras
    }


@pytest.fixture(scope="module")
def noisy():
    """A fit of noisy pictures, from a map of one grey."""
    true = room()
    return fit_texture(room(np.full_like(TRUE, 0.5)), "map", pictures(true, NOISE))


def test_the_inverse_of_a_banded_matrix_is_the_dense_one():
    """Of a random sparse matrix, and of a map that closes around itself."""
    random = sparse.random(300, 60, 0.04, random_state=0, format="csr") + 0.3 * sparse.eye(300, 60)
    line = sparse.diags_array([0.5, 1.0, 0.5, 0.5], offsets=[-1, 0, 1, 8], shape=(9, 9))
    for jacobian in (random, sparse.kron(line, line)):
        normal = sparse.csr_array(jacobian.T @ jacobian) + 1e-3 * sparse.eye_array(jacobian.shape[1])
        dense, right = np.linalg.inv(normal.toarray()), np.arange(jacobian.shape[1], dtype=float)
        np.testing.assert_allclose(Banded.of(normal).inverse_diagonal(), np.diag(dense), rtol=1e-7)
        np.testing.assert_allclose(Banded.of(normal).solve(right), dense @ right, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("size", [1, 3, 5, 8, 13, 64])
def test_texels_that_move_together_are_apart_around_the_map_too(size):
    marks = _stripes(size, 4)
    for k in range(marks.max() + 1):
        places = np.flatnonzero(marks == k)
        gaps = np.diff([*places, places[0] + size])
        assert len(places) == 1 or gaps.min() >= 4


def test_an_answer_of_two_texels_is_nobodys():
    amounts = np.array([[0.6, 0.9, 1.2], [1.4, 0.7, 1.0]])
    one, two = amounts[:, 1], amounts[:, [0, 2]].mean(axis=1)
    texel, sure = _nearest([np.array([a, b]) for a, b in zip(one, two, strict=True)], np.array([7, 8, 9]), amounts)
    assert texel[0] == 8 and sure.tolist() == [True, False]


def test_texels_are_found_and_judged_as_by_a_dense_inverse(noisy):
    """The Jacobian column by column, from pictures in which one texel is raised; they are linear in it."""
    scene = room()

    @jax.jit
    def look(texels):
        changed = dw.replace_parameter(scene, "texture.map.texels", texels)
        return jnp.stack([dw.render(changed, scene.cameras[name]) for name in ("left", "right")])

    base, columns = look(TRUE), []
    for k in range(TRUE.shape[0] * TRUE.shape[1]):
        raised = TRUE.reshape(-1, 3).copy()
        raised[k] += 0.5
        columns.append(2 * np.asarray(look(raised.reshape(TRUE.shape)) - base).reshape(-1, 3))
    jacobian = np.stack(columns, axis=1)
    seen = noisy.seen.ravel()
    assert 40 < seen.sum() <= 64 and noisy.status == "converged" and not noisy.left_out
    for channel in range(3):
        mine = jacobian[:, abs(jacobian[..., channel]).max(axis=0) > 1e-4, channel]
        whole = np.full(len(seen), np.nan)
        whole[abs(jacobian[..., channel]).max(axis=0) > 1e-4] = np.sqrt(np.diag(np.linalg.inv(mine.T @ mine)))
        expected = noisy.noise * whole
        np.testing.assert_allclose(noisy.standard_errors.reshape(-1, 3)[seen, channel], expected[seen], rtol=1e-4)
    assert noisy.noise == pytest.approx(NOISE, rel=0.1)
    apart = ((noisy.texels - TRUE) / noisy.standard_errors)[noisy.seen]
    assert 0.8 < np.sqrt((apart**2).mean()) < 1.2


def test_what_no_picture_sees_is_said_and_left():
    """One camera, and half of the wall outside of its picture."""
    true, start = room(), room(np.full_like(TRUE, 0.5))
    narrow = dw.Camera((-0.5, 0, 2.5), (-0.7, 0, 0), 20, *SMALL)
    scenes = [dw.Scene(**{key: getattr(s, key) for key in ("objects", "materials", "lights", "textures")}, max_depth=2,
                       cameras={"left": narrow}, precision="float64") for s in (true, start)]  # fmt: skip
    found = fit_texture(scenes[1], "map", pictures(scenes[0], cameras=("left",)))
    assert found.seen.any() and (~found.seen[:, 5:]).all()
    assert np.isnan(found.standard_errors[~found.seen]).all() and np.allclose(found.texels[:, 6:], 0.5)
    np.testing.assert_allclose(found.texels[found.seen], TRUE[found.seen], atol=1e-6)
    assert f"{found.seen.sum()} of 64 texels are seen" in found.message


def test_a_map_that_a_mirror_shows_once_more(monkeypatch):
    """Pixels that see it in two places, which texels so near each other do not tell apart, count in the texels, by
    products through the recorded trees.
    """
    monkeypatch.setattr(_map_solve, "map_rows", partial(map_rows, apart=(3,)))
    true = room(mirror=0.6)
    found = fit_texture(room(np.full_like(TRUE, 0.5), mirror=0.6), "map", pictures(true))
    assert found.status == "converged" and found.left_out > 2 and "in several places" in found.message
    np.testing.assert_allclose(found.texels[found.seen], TRUE[found.seen], atol=1e-5)


def test_more_left_over_than_noise_can_be():
    """The lamp of the targets was brighter on one side."""
    true = pictures(room())
    true["left"] = true["left"] * 1.1
    targets = [Target(picture, name, noise=NOISE) for name, picture in true.items()]
    found = fit_texture(room(np.full_like(TRUE, 0.5)), "map", targets)
    assert found.status == "misfit" and "times the stated noise" in found.message


def test_what_cannot_be_fitted_is_said():
    scene, seen = room(), {"left": np.ones((*SMALL[::-1], 3))}
    with pytest.raises(FitError, match="'mop' is no image texture.*Did you mean 'map'"):
        fit_texture(scene, "mop", seen)
    with pytest.raises(FitError, match="footprint = 3"):
        fit_texture(scene, "map", seen, footprint=3)
    unworn = dw.Scene(objects=scene.objects[1:], materials=scene.materials, lights=scene.lights, cameras=scene.cameras,
                      textures=scene.textures, precision="float64")  # fmt: skip
    with pytest.raises(FitError, match="no object wears texture 'map'"):
        fit_texture(unworn, "map", seen)
    with pytest.raises(FitError, match="18x24|24x18"):
        fit_texture(scene, "map", {"left": np.ones((4, 4, 3))})


def test_the_command_writes_the_map_and_its_errors(tmp_path, monkeypatch, capsys):
    (tmp_path / "scene").mkdir()
    for name, texels in (("true", TRUE), ("grey", np.full_like(TRUE, 0.5))):
        dw.write_image(tmp_path / "scene" / f"{name}.exr", texels)
    scene = room(np.full_like(TRUE, 0.5), precision="float32", file=str(tmp_path / "scene" / "grey.exr"))
    dw.save_scene(scene, tmp_path / "scene" / "scene.toml")
    for name, picture in pictures(room(precision="float32")).items():
        dw.write_image(tmp_path / f"{name}.exr", picture.astype(np.float32))
    monkeypatch.chdir(tmp_path)
    targets = [f"--target={name}={name}.exr" for name in ("left", "right")]
    assert main(["fit", "scene/scene.toml", "--texture", "map", *targets, "--out", "found"]) == 0
    assert "converged" in capsys.readouterr().out
    result = json.loads((tmp_path / "found" / "result.json").read_text())
    assert result["status"] == "converged" and result["texels"]["seen"] + result["texels"]["unseen"] == 64
    errors = dw.read_image(tmp_path / "found" / "map.standard_errors.exr").pixels
    seen = np.isfinite(errors).all(axis=-1)
    assert seen.sum() == result["texels"]["seen"]
    fitted = dw.load_scene(tmp_path / "found" / "fitted.toml")
    np.testing.assert_allclose(fitted.textures["map"].texels[seen], TRUE[seen], atol=1e-4)
    assert main(["fit", "scene/scene.toml", "--texture", "map", "--free", "paint.k_d", *targets, "--out", "no"]) == 2
    assert "--free does not go with --texture" in capsys.readouterr().err
    assert main(["fit", "scene/scene.toml", *targets, "--out", "no"]) == 2
    assert "--free" in capsys.readouterr().err
