"""A camera with a lens: circles of confusion, derivatives, a fit, and the error against samples."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.accuracy._tracer import Tracer

WIDTH, HEIGHT = 24, 18
VFOV = 20.0
PIXEL = 2 * np.tan(np.radians(VFOV / 2)) / HEIGHT
"""Of a pinhole at distance 1."""


def balls(aperture=0.5, focus=6.0, samples=16, **settings):
    """A ball nearer than what is sharp and one beyond, under an even light."""
    lens = {} if aperture is None else {"aperture": aperture, "focus": focus, "blur_samples": samples}
    return dw.Scene(
        objects=[dw.Sphere("near", (-0.4, 0, 2), 0.35, "red"), dw.Sphere("far", (0.5, 0.2, -3), 0.8, "blue")],
        materials={"red": dw.Material(k_a=(0.9, 0.2, 0.1)), "blue": dw.Material(k_a=(0.1, 0.3, 0.9))},
        cameras={"main": dw.Camera((0, 0, 6), (0, 0, 0), VFOV, WIDTH, HEIGHT, **lens)},
        background=dw.ConstantBackground((0.3, 0.3, 0.3)),
        max_depth=1,
        precision="float64",
        **settings,
    )


def picture(scene, **how):
    return np.asarray(dw.render(scene, scene.cameras["main"], **how))


@pytest.mark.parametrize("focus", [3.0, 12.0])
def test_a_point_becomes_a_disc_of_the_diameter_of_the_thin_lens(focus):
    """c = A |d - f| / (f d) of a point at distance d, at distance 1 behind the pinhole; an even disc has the second
    moment c^2 / 8 about its middle.
    """
    aperture, distance = 1.2, 6.0
    lens = {"aperture": aperture, "focus": focus, "blur_samples": 1024}
    scene = dw.Scene(
        objects=[dw.Sphere("dot", (0, 0, 0), 0.05, "lamp")],
        materials={"lamp": dw.Material(k_a=1)},
        cameras={"main": dw.Camera((0, 0, distance), (0, 0, 0), VFOV, WIDTH, HEIGHT, **lens)},
        max_depth=1,
        precision="float64",
    )
    light = picture(scene, samples=16)[..., 0]
    row, column = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    square = ((column - WIDTH / 2) ** 2 + (row - HEIGHT / 2) ** 2) * PIXEL**2
    # The dot itself, and the pixels as squares, spread the light too.
    found = (light * square).sum() / light.sum() - (0.05 / distance) ** 2 / 2 - PIXEL**2 / 6
    across = aperture * abs(distance - focus) / (focus * distance)
    assert found == pytest.approx(across**2 / 8, rel=0.02)
    assert light[square > (across / 2 + 0.05 / distance + PIXEL) ** 2].max() == 0
    # No light is lost: the picture of the dot is as bright as through a pinhole.
    dot = np.pi * (0.05 / distance / PIXEL) ** 2
    assert light.sum() == pytest.approx(dot, rel=0.05)


def test_what_is_in_focus_and_what_has_no_lens_is_sharp():
    pinhole = picture(balls(None))
    np.testing.assert_array_equal(picture(balls(0.0)), pinhole)
    assert "lens" not in dw.plan(balls(0.0), balls(0.0).cameras["main"]).effects
    near = dw.replace_parameter(balls(), "camera.main.focus", 4.0)
    there = abs(picture(near)[:, :12] - pinhole[:, :12]).mean()
    assert there < 0.4 * abs(picture(balls())[:, :12] - pinhole[:, :12]).mean()


def waves(aperture=1.5, focus=6.0, samples=32):
    """A slanted floor with a pattern without edges, which goes from near to far."""
    row, column = np.mgrid[:16, :16] * (2 * np.pi / 16)
    pattern = np.stack([0.5 + 0.4 * np.sin(column), 0.5 + 0.4 * np.sin(row), np.full_like(row, 0.5)], axis=-1)
    lens = {"aperture": aperture, "focus": focus, "blur_samples": samples}
    return dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0.5), 0, "floor")],
        materials={"floor": dw.Material(k_a=1, k_a_texture="waves")},
        textures={
            "waves": dw.ImageTexture(
                pattern, mapping="planar", origin=(0, 0, 0), edge_u=(0.5, 0, 0), edge_v=(0, 0, 0.5), wrap="repeat"
            )
        },
        cameras={"main": dw.Camera((0, 2, 6), (0, 0, 0), VFOV, WIDTH, HEIGHT, **lens)},
        max_depth=1,
        precision="float64",
    )


def test_the_derivatives_in_the_numbers_of_a_lens_are_those_of_the_picture():
    """Forward and backward, against differences."""
    scene = waves()
    plan = dw.plan(scene, scene.cameras["main"])
    weight = jnp.asarray(np.random.default_rng(3).normal(size=(HEIGHT, WIDTH, 3)))

    def image(numbers):
        changed = scene
        for name, number in zip(("aperture", "focus"), numbers, strict=True):
            changed = dw.replace_parameter(changed, f"camera.main.{name}", number)
        return dw.render(changed, changed.cameras["main"], plan=plan)

    at = jnp.asarray([1.5, 6.0])
    slopes = np.asarray(jax.jit(jax.jacfwd(image))(at))
    back = jax.jit(jax.grad(lambda v: (weight * image(v)).sum()))(at)
    np.testing.assert_allclose(back, np.einsum("yxc,yxck", weight, slopes), rtol=1e-8)
    seen = jax.jit(image)
    for k, step in enumerate((1e-7, 1e-6)):
        way = step * np.eye(2)[k]
        difference = np.asarray(seen(at + way) - seen(at - way)) / (2 * step)
        assert abs(slopes[..., k]).max() > 0.02
        np.testing.assert_allclose(slopes[..., k], difference, atol=0.01 * abs(difference).max())


@pytest.mark.slow
def test_blurred_edges_move_with_the_aperture():
    """With a footprint, against differences of converged pictures."""
    name, value, step = "aperture", 0.5, 0.01
    scene = balls(samples=64)

    def make(number):
        return dw.replace_parameter(scene, f"camera.main.{name}", number)

    slope = dw.derivative(make, value, "main").slope
    ends = [
        picture(dw.replace_parameter(balls(samples=4096), f"camera.main.{name}", value + s * step), samples=8)
        for s in (-1, 1)
    ]
    difference = (ends[1] - ends[0]) / (2 * step)
    assert np.sqrt(((slope - difference) ** 2).mean()) < 0.25 * np.sqrt((difference**2).mean())
    assert (slope * difference).sum() / (difference**2).sum() == pytest.approx(1, abs=0.1)


@pytest.mark.slow
def test_aperture_and_focus_are_found():
    truth = picture(waves(1.5, 6.0, 1024), samples=8)
    found = fitting.fit(waves(1.0, 6.4), truth, free=("camera.main.aperture", "camera.main.focus"))
    by_name = {c.name: c.value for c in found.coefficients}
    assert abs(by_name["camera.main.aperture"] - 1.5) < 0.05 and abs(by_name["camera.main.focus"] - 6.0) < 0.1


def test_more_samples_are_nearer_and_a_tracer_takes_those_of_render():
    scene = balls()
    tracer = Tracer(scene, scene.cameras["main"])
    settings = dw.Settings(depth=1, blur_samples=64)
    np.testing.assert_allclose(
        tracer.trace(settings).pixels.reshape(HEIGHT, WIDTH, 3), picture(balls(samples=64)), atol=1e-12
    )
    some = replace(settings, samples=2)
    spread = tracer.trace_spread(some, np.arange(7, 90)).pixels
    np.testing.assert_allclose(spread, tracer.trace(some).pixels[7:90], atol=1e-12)
    truth = tracer.trace(replace(settings, blur_samples=2048)).pixels
    errors = [
        np.sqrt(((tracer.trace(replace(settings, blur_samples=n)).pixels - truth) ** 2).mean()) for n in (4, 32, 256)
    ]
    assert all(after < 0.4 * before for before, after in zip(errors, errors[1:], strict=False))


def test_a_seed_decides_on_the_noise():
    first, again, other = picture(balls()), picture(balls()), picture(balls(seed=5))
    np.testing.assert_array_equal(first, again)
    assert 1e-4 < abs(first - other).mean() < 0.02


@pytest.mark.parametrize(
    "keys, message",
    [
        ({"aperture": 0.1}, "camera: aperture is stated without focus; allowed are both"),
        ({"focus": 2.0}, "camera: focus is stated without aperture; allowed are both"),
        ({"aperture": -0.1, "focus": 2.0}, "camera: aperture = -0.1; allowed is >= 0"),
        ({"aperture": 0.1, "focus": 0.0}, "camera: focus = 0; allowed is > 0"),
        ({"aperture": 0.1, "focus": 1.0, "blur_samples": 0}, "blur_samples = 0; allowed is a whole number from 1 to"),
    ],
)
def test_what_is_no_lens_is_named(keys, message):
    with pytest.raises(dw.SceneError, match=message):
        dw.Camera((0, 0, 6), (0, 0, 0), 40, 8, 6, **keys)
