"""Rough surfaces: against sums over normals, in their derivative, in a fit."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted._errors import SceneNote
from diffwhitted.accuracy._reference import reference, rmse
from diffwhitted.accuracy._survey import swept_knobs
from diffwhitted.accuracy._tracer import Tracer

WIDTH, HEIGHT = 12, 9
STEEP = slice(4, None)
"""Rows whose mirror rays stay above the floor: one that would go into it is turned until it grazes it."""


def floor(roughness, samples=16, **settings):
    """A floor that mirrors a sky that changes with the height."""
    rough = {} if roughness is None else {"roughness": roughness, "roughness_samples": samples}
    return dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0), 0, "floor")],
        materials={"floor": dw.Material(k_s=0.8, k_h=0, **rough)},
        cameras={"main": dw.Camera((0, 2, 4), (0, 0, 0), 30, WIDTH, HEIGHT)},
        background=dw.GradientBackground((0.2, 0.2, 0.2), (1, 0.5, 0.1)),
        max_depth=2,
        precision="float64",
        **settings,
    )


def picture(scene):
    return np.asarray(dw.render(scene, scene.cameras["main"]))


def mean_over_normals(roughness, nodes=48):
    """The same picture by a Gauss-Hermite rule over the slopes, for each pixel by itself."""
    scene = floor(None)
    camera = scene.cameras["main"]
    ray = camera.rays(*camera.place(jnp.arange(WIDTH * HEIGHT), jnp.asarray([0.5, 0.5])))
    u = np.stack([ray.direction.x, ray.direction.y, ray.direction.z], axis=-1)
    z, weight = np.polynomial.hermite_e.hermegauss(nodes)
    weight = weight / weight.sum()
    one, other = np.meshgrid(z * roughness, z * roughness)
    normal = np.stack([one, np.ones_like(one), other], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    up = u[:, None, None, 1] - 2 * (u[:, None, None] * normal).sum(axis=-1) * normal[..., 1]
    height = 0.5 * (1 + (up * weight * weight[:, None]).sum(axis=(1, 2)))[:, None]
    bottom, top = np.array([0.2, 0.2, 0.2]), np.array([1, 0.5, 0.1])
    return (0.8 * (bottom * (1 - height) + top * height)).reshape(HEIGHT, WIDTH, 3)


def test_more_samples_come_nearer_to_the_mean_over_normals():
    expected = mean_over_normals(0.08)[STEEP]
    few, many = (np.sqrt(((picture(floor(0.08, n))[STEEP] - expected) ** 2).mean()) for n in (4, 256))
    assert few < 0.005 and many < 2e-4 and many < few / 8


def test_a_surface_that_is_hardly_rough_is_smooth():
    np.testing.assert_allclose(picture(floor(1e-9)), picture(floor(None)), atol=1e-8)


def test_another_seed_draws_other_samples_and_the_same_one_the_same():
    first, again, other = picture(floor(0.1)), picture(floor(0.1)), picture(floor(0.1, seed=7))
    np.testing.assert_array_equal(first, again)
    assert 1e-4 < abs(first - other).mean() < 0.02


def test_roughness_has_the_derivative_of_the_picture():
    scene = floor(0.08, 64)
    plan = dw.plan(scene, scene.cameras["main"])

    def image(roughness):
        return dw.render(dw.replace_parameter(scene, "floor.roughness", roughness), scene.cameras["main"], plan=plan)

    both = jax.jit(lambda r: jax.jvp(image, (r,), (jnp.ones_like(r),)))
    slope = np.asarray(both(jnp.asarray(0.08))[1])
    step = 1e-5
    difference = np.asarray(both(0.08 + step)[0] - both(0.08 - step)[0]) / (2 * step)
    assert abs(slope).max() > 0.05
    np.testing.assert_allclose(slope, difference, atol=2e-3 * abs(slope).max())
    of_mean = (mean_over_normals(0.081) - mean_over_normals(0.079)) / 0.002
    assert np.sqrt(((slope - of_mean)[STEEP] ** 2).mean()) < 0.15 * np.sqrt((of_mean[STEEP] ** 2).mean())


def test_roughness_is_found():
    truth = mean_over_normals(0.06)
    found = fitting.fit(floor(0.03, 64), truth, free=("floor.roughness", "floor.k_s"))
    by_name = {c.name: c.value for c in found.coefficients}
    assert abs(by_name["floor.roughness"] - 0.06) < 0.004 and abs(by_name["floor.k_s"] - 0.8) < 2e-3


def test_frosted_glass_scatters_what_comes_through():
    glass = dw.Material(k_t=1, k_h=0, refractive_index=1.5, roughness=0.1, roughness_samples=64)
    scene = dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "glass")],
        materials={"glass": glass},
        cameras={"main": dw.Camera((0, 0, 4), (0, 0, 0), 25, WIDTH, HEIGHT)},
        background=dw.ConstantBackground((0.3, 0.5, 0.7)),
        precision="float64",
        max_depth=6,
    )
    # Near its rim light goes round within it until the tree ends.
    middle = picture(scene)[3:-3, 4:-4]
    np.testing.assert_allclose(middle, np.broadcast_to([0.3, 0.5, 0.7], middle.shape), atol=1e-9)


def test_a_footprint_is_taken_by_points():
    with pytest.warns(SceneNote, match=r"material 'floor' \(roughness\) knows points only"):
        found = dw.render(floor(0.08), floor(0.08).cameras["main"], footprint=1)
    assert abs(np.asarray(found) - mean_over_normals(0.08)).mean() < 0.01


def test_what_is_smooth_has_no_roughness_to_free():
    with pytest.raises(dw.SceneError, match="'floor.roughness': material 'floor' states none; write one"):
        dw.parameter_value(floor(None), "floor.roughness")
    with pytest.raises(dw.SceneError, match="roughness_samples = 0; allowed is a whole number from 1 to 4096"):
        dw.Material(k_s=1, roughness=0.1, roughness_samples=0)
    with pytest.raises(dw.SceneError, match="seed = -1; allowed is"):
        floor(0.1, seed=-1)


def test_a_knob_chooses_the_samples_of_what_is_rough():
    """What the scene says is left alone; places in a pixel draw by themselves, and come to the mean over normals."""
    scene = floor(0.08, 16)
    tracer, expected = Tracer(scene, scene.cameras["main"]), mean_over_normals(0.08)[STEEP].reshape(-1, 3)
    assert {"roughness_samples"} <= {knob.name for knob in swept_knobs(tracer)} >= {"depth"}

    def traced(normals=None, **how):
        return tracer.trace(dw.Settings(roughness_samples=normals, **how)).pixels[-len(expected) :]

    np.testing.assert_allclose(traced(), picture(scene)[STEEP].reshape(-1, 3), atol=1e-12)
    one, many = rmse(traced(1), expected), rmse(traced(64), expected)
    assert one > 0.01 and many < one / 8
    assert rmse(traced(1, samples=8), traced(64, samples=8)) < one / 4
    truth = reference(tracer, np.arange(4 * WIDTH, 5 * WIDTH), variant=dw.Settings(roughness_samples=4))
    assert str(truth).endswith("4 normals a tree") and rmse(truth.pixels, traced(64)[:WIDTH]) < 1e-3
    with pytest.raises(dw.SceneError, match="roughness_samples = 0; allowed is a whole number from 1 to 4096"):
        dw.Settings(roughness_samples=0)
