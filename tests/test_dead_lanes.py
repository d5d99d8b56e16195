"""Lanes of a block that carry no ray: whatever their arithmetic gives reaches neither the film nor a derivative."""

from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED

import diffwhitted as dw
from diffwhitted.numerics._stage import always, stage

FIELD = Path(__file__).parent / "field"


@pytest.mark.parametrize("case", ["nonfinite_500080", "nonfinite_500184"])
@pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
def test_what_a_dead_lane_computes_reaches_nothing(case):
    """Far from the origin, through glass: a lane without a ray is NaN here, where the picture made op by op is
    finite.
    """
    scene = dw.load_scene(FIELD / f"{case}.toml")
    camera = scene.cameras["main"]
    plan = dw.plan(scene, camera)

    @eqx.filter_jit(compiler_options=SOON_COMPILED)
    def picture_and_gradient(scene):
        def total(scene):
            image = dw.render(scene, scene.cameras["main"], plan=plan)
            return image.sum(), image

        return eqx.filter_value_and_grad(total, has_aux=True)(scene)

    (_, image), gradient = picture_and_gradient(scene)
    assert np.isfinite(np.asarray(dw.render(scene, camera, plan=plan))).all()
    assert np.isfinite(np.asarray(image)).all()
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(gradient))


@pytest.mark.parametrize(
    "numbers",
    [
        np.array([np.nan, 0, 1]),
        np.array([-np.inf]),
        np.array([0.0]),
        np.array([np.iinfo(np.int32).min, 5], np.int32),
        np.array([-1], np.int32),
        np.array([np.iinfo(np.int32).max], np.int32),
    ],
)
def test_always_is_true_and_is_not_folded_away(numbers):
    """For NaN and every integer; and the stage that asks for it is still a branch of the compiled program."""
    assert bool(always(jnp.asarray(numbers)))
    program = jax.jit(lambda a: stage(always(a), lambda a: a * a + 1, a)).lower(numbers).compile()
    assert "conditional" in program.as_text()
