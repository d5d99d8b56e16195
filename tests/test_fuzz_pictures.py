"""The random scenes of `test_fuzz`, looked at in more ways than one: each way must be finite, never dark below 0, and
the same.

One scene of each structure is a program; everything that is a number varies. Where exact arithmetic has a tie, which
these scenes look for (a light in the plane of the floor, a camera on a surface), rounding breaks it pixel by pixel;
so two precisions of one picture agree in nearly all pixels of most scenes, not of all. What is the same arithmetic
agrees in all.
"""

import functools

import equinox as eqx
import jax
import numpy as np
import pytest
from conftest import SOON_COMPILED
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_fuzz import KINDS

import diffwhitted as dw
from diffwhitted.accuracy._choose import in_precision
from diffwhitted.records import changed
from diffwhitted.tree import make_plan

pytestmark = pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
"""Random scenes are often black, or have lamps inside of things."""
AGREE = 1e-3
drawn = functools.partial(
    settings, derandomize=True, database=None, deadline=None, suppress_health_check=list(HealthCheck)
)


def everything(scene, footprint=0):
    """A plan with all that the coefficients may call for, and room for all rays."""
    free = tuple(f"{name}.{row.name}" for name in scene.materials for row in dw.COEFFICIENTS)
    return make_plan(scene, scene.cameras["main"], free=free, footprint=footprint)


def picture_of(**how):
    """A program for pictures of one structure of scenes, with a plan of the first one or without any."""
    plans = []

    @eqx.filter_jit(compiler_options=SOON_COMPILED)
    def program(scene):
        return dw.render(scene, scene.cameras["main"], plan=plans[0] if plans else None)

    def picture(scene):
        if not plans and "footprint" in how:
            plans.append(everything(scene, how["footprint"]))
        return np.asarray(program(scene))

    return picture


def moved(scene, by):
    """The scene with all its places moved, in float64."""
    parts = {part: tuple(one.moved(by) for one in getattr(scene, part)) for part in ("objects", "lights")}
    parts |= {
        part: {name: one.moved(by) for name, one in getattr(scene, part).items()} for part in ("textures", "cameras")
    }
    return changed(scene, keeps_digits=True, **parts)


def check(image):
    assert image.shape == (6, 8, 3) and np.isfinite(image).all() and (image >= 0).all()
    return image


class Agreement:
    """Counts the pixels in which two ways of a picture agree, relative to the brighter one where that is above 1."""

    def __init__(self):
        self.shares = []

    def of(self, one, other):
        off = np.abs(one - other).max(axis=-1) / np.maximum(1, np.maximum(one, other).max(axis=-1))
        self.shares.append(np.mean(off < AGREE))

    def require(self, scenes):
        """Of so many scenes all pixels but a twentieth agree."""
        shares = np.array(self.shares)
        assert len(shares) > 5 and np.mean(shares >= 0.95) >= scenes, sorted(shares)[:5]


@pytest.mark.parametrize("kind", KINDS)
def test_a_plan_or_none_one_or_several_and_both_precisions(kind):
    """Under `jit`: with a plan, without one, as one of a batch, and in float64."""
    planned, without, double = picture_of(footprint=0), picture_of(), picture_of(footprint=0)
    batch, plans = [], []

    @eqx.filter_jit(compiler_options=SOON_COMPILED)
    def of_batch(scenes):
        arrays, rest = eqx.partition(scenes, eqx.is_array)

        def one(arrays):
            scene = eqx.combine(arrays, rest)
            return dw.render(scene, scene.cameras["main"], plan=plans[0])

        return jax.vmap(one)(arrays)

    unplanned, precise = Agreement(), Agreement()

    @drawn(max_examples=20)
    @given(scene=KINDS[kind].filter(lambda scene: not scene.keeps_digits))
    def same(scene):
        image = check(planned(scene))
        unplanned.of(image, check(without(scene)))
        precise.of(image, check(double(in_precision(scene, "float64"))))
        batch.append((scene, image))

    same()
    unplanned.require(0.95)
    precise.require(0.85)
    scenes, images = zip(*batch[-2:], strict=True)
    plans.append(everything(scenes[0]))
    together = of_batch(jax.tree.map(lambda *a: np.stack(a), *scenes))
    batched = Agreement()
    for image, one in zip(images * 3, [*np.asarray(together)] * 3, strict=True):
        batched.of(image, check(one))
    batched.require(1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_up_to_a_million_metres_away(kind):
    """The scene moved by whole periods of its pattern is the same picture, traced near its camera."""
    away, plans = Agreement(), {}

    def plan_for(scene):
        """The plan of the first scene, and another one where objects have a surface in common."""
        needed = everything(scene)
        return plans.setdefault(needed.shared, needed)

    @drawn(max_examples=20)
    @given(scene=KINDS[kind], by=st.tuples(*[st.integers(-(2**16), 2**16)] * 3))
    def same(scene, by):
        period = 2 * float(scene.textures["tiles"].size) if scene.textures else 1.0
        by = np.round(np.array(by, float) * 2**20 / 2**16 / period) * period
        there = moved(scene, by)
        image, other = (check(np.asarray(dw.render(s, s.cameras["main"], plan=plan_for(s)))) for s in (scene, there))
        away.of(image, other)

    same()
    away.require(0.85)


@pytest.mark.parametrize("footprint", [1, 2])
def test_footprints_are_finite_and_never_dark_below_zero(footprint):
    picture = picture_of(footprint=footprint)

    @drawn(max_examples=25)
    @given(scene=KINDS["nested"].filter(lambda scene: not scene.keeps_digits))
    def finite(scene):
        check(picture(scene))

    finite()


def test_antialiased_pictures_are_finite_and_never_dark_below_zero():
    @drawn(max_examples=10)
    @given(scene=KINDS["nested"].filter(lambda scene: not scene.keeps_digits))
    def finite(scene):
        check(np.asarray(dw.render(scene, scene.cameras["main"], antialias=0.1)))

    finite()
