"""Motion blur: streaks, what moves with what, derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from shape_samples import THINGS

import diffwhitted as dw
from diffwhitted.scene._motion import motion_of
from diffwhitted.scene._search import shapes_of

WIDTH, HEIGHT = 32, 8
PIXEL = 0.1


def card(velocity=(2.0, 0, 0), moving_camera=None, shutter=0.5, samples=64, **settings):
    """A white card 1 m wide, 4 m high, before a camera of parallel rays whose pixels are 0.1 m wide."""
    corners = [(-0.5, -2, 0), (0.5, -2, 0), (0.5, 2, 0), (-0.5, 2, 0)]
    blur = {"shutter": shutter, "velocity": moving_camera, "blur_samples": samples}
    return dw.Scene(
        objects=[dw.Polygon("card", corners, "card").moving(velocity)],
        materials={"card": dw.Material(k_a=1)},
        cameras={"main": dw.OrthographicCamera((0, 0, 5), (0, 0, 0), HEIGHT * PIXEL, WIDTH, HEIGHT, **blur)},
        max_depth=1,
        precision="float64",
        **settings,
    )


def picture(scene, **how):
    return np.asarray(dw.render(scene, scene.cameras["main"], **how))


def streak(speed, shutter=0.5):
    """The part of the time that the card stands before a place (x of the middle of a pixel)."""
    x = (np.arange(WIDTH) + 0.5 - WIDTH / 2) * PIXEL
    path = speed * shutter / 2
    return np.clip((np.minimum(x + 0.5, path) - np.maximum(x - 0.5, -path)) / (2 * path), 0, 1)


def test_a_card_leaves_a_streak():
    np.testing.assert_allclose(picture(card())[4, :, 0], streak(2.0), atol=0.02)


def test_more_samples_are_nearer():
    errors = [np.sqrt(np.mean((picture(card(samples=n))[4, :, 0] - streak(2.0)) ** 2)) for n in (8, 64, 512)]
    assert errors[0] < 0.1 and all(after < 0.3 * before for before, after in zip(errors, errors[1:], strict=False))


def test_a_camera_that_moves_sees_the_same():
    """And one that goes along sees the card at rest."""
    np.testing.assert_allclose(picture(card(None, (-2.0, 0, 0))), picture(card()), atol=1e-12)
    np.testing.assert_allclose(picture(card((2.0, 0, 0), (2.0, 0, 0))), picture(card(None)), atol=1e-12)


def test_nothing_is_paid_for_what_is_at_rest():
    for scene in (card(None), card(shutter=None), card(shutter=0.0), card((0.0, 0, 0))):
        plan = dw.plan(scene, scene.cameras["main"])
        assert "motion" not in plan.effects and plan.chances == 1


@pytest.mark.slow
def test_the_shutter_has_the_derivative_of_the_streak():
    """With a footprint, whose edges move."""
    scene = card(samples=64)
    slope = dw.derivative(
        lambda v: dw.replace_parameter(scene, "camera.main.shutter", v), 0.5, "main", refine=False
    ).slope[4, :, 0]
    expected = (streak(2.0, 0.51) - streak(2.0, 0.49)) / 0.02
    assert np.sqrt(np.mean((slope - expected) ** 2)) < 0.2 * np.sqrt(np.mean(expected**2))
    # What the streak loses in the middle it gains at its ends.
    assert abs(slope.sum()) < 0.05 * abs(slope).sum()


def sliding(velocity, moving_camera=None, shutter=1.0):
    """A floor with a pattern without edges."""
    row, column = np.mgrid[:16, :16] * (2 * np.pi / 16)
    pattern = np.stack([0.5 + 0.4 * np.sin(column), 0.5 + 0.4 * np.sin(row), np.full_like(row, 0.5)], axis=-1)
    blur = {"shutter": shutter, "velocity": moving_camera, "blur_samples": 16}
    return dw.Scene(
        objects=[dw.Plane("floor", (0, 1, 0), 0, "floor").moving(velocity)],
        materials={"floor": dw.Material(k_a=1, k_a_texture="waves")},
        textures={
            "waves": dw.ImageTexture(
                pattern, mapping="planar", origin=(0, 0, 0), edge_u=(2, 0, 0), edge_v=(0, 0, 2), wrap="repeat"
            )
        },
        cameras={"main": dw.Camera((0, 2, 4), (0, 0, 0), 40, 16, 12, **blur)},
        max_depth=1,
        precision="float64",
    )


def test_shutter_and_velocity_have_the_derivatives_of_the_picture():
    """Forward and backward, against differences."""
    scene = sliding((1.3, 0.0, 0.4))
    plan = dw.plan(scene, scene.cameras["main"])
    weight = jnp.asarray(np.random.default_rng(3).normal(size=(12, 16, 3)))

    def score(numbers):
        changed = dw.replace_parameter(scene, "camera.main.shutter", numbers[0])
        changed = dw.replace_parameter(changed, "object.floor.velocity.x", numbers[1])
        return (weight * dw.render(changed, changed.cameras["main"], plan=plan)).sum()

    at, way = jnp.asarray([1.0, 1.3]), jnp.asarray([1.0, -0.7])
    back = jax.jit(jax.grad(score))(at)
    value = jax.jit(lambda v: jax.jvp(score, (v,), (way,)))
    assert abs(back).min() > 0.1
    np.testing.assert_allclose(value(at)[1], back @ way, rtol=1e-9)
    step = 1e-6
    difference = (value(at + step * way)[0] - value(at - step * way)[0]) / (2 * step)
    np.testing.assert_allclose(value(at)[1], difference, rtol=0.01)


def test_patterns_go_along_with_what_they_are_on():
    """A floor that slides under a camera which goes along shows its pattern as at rest."""
    velocity = (1.3, 0, 0.4)
    np.testing.assert_allclose(picture(sliding(velocity, velocity)), picture(sliding(None)), atol=1e-9)
    assert abs(picture(sliding(velocity)) - picture(sliding(None))).max() > 0.1


def test_surfaces_at_a_time_are_those_of_the_objects_there():
    """Of every kind; the trees by which many are searched are made anew."""
    velocity, time = np.asarray([0.3, -0.7, 0.2]), 0.6
    many = dw.SphereSet("many", np.random.default_rng(1).uniform(-1, 1, (300, 3)), 0.08, "m")
    things = [thing.moving(velocity).as_placed() for thing in (many, *THINGS.values())]
    things = [thing for kind in dw.scene.OBJECTS for thing in things if type(thing) is kind]
    there = [thing.transformed(np.eye(3), velocity * time, "here") for thing in things]
    moved = motion_of(things, jnp.float64).at(shapes_of(things, (), None), jnp.asarray(time))
    assert any(tree is not None for tree in moved.boxes)
    for one, other in zip(jax.tree.leaves(moved), jax.tree.leaves(shapes_of(there, (), None)), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6)


def test_a_velocity_is_written_and_read(tmp_path):
    dw.save_scene(card(), tmp_path / "scene.toml")
    again = dw.load_scene(tmp_path / "scene.toml")
    np.testing.assert_array_equal(again.objects[0].velocity, (2, 0, 0))
    assert float(again.cameras["main"].shutter) == 0.5 and again.cameras["main"].blur_samples == 64
    with pytest.raises(dw.SceneError, match="object 'card': velocity"):
        card((1, 2))
