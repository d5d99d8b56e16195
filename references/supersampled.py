"""The three scenes on which derivatives through moving edges are measured, and their converged references."""

from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted as dw
from diffwhitted.tree import grid, make_plan, tables_of, trace

EXAMPLE = Path(__file__).parent.parent / "examples" / "glass_between_spheres.toml"
INDEX = "glass.refractive_index"


def spheres():
    """Glass between two mirroring spheres over a checkerboard, two lights with shadows."""
    return dw.load_scene(EXAMPLE)


def glass_alone():
    """The glass over the checkerboard."""
    scene = spheres()
    return eqx.tree_at(lambda s: s.objects, scene, tuple(o for o in scene.objects if o.name in ("ball", "ground")))


def smooth():
    """The glass before a smooth gradient."""
    scene = spheres()
    scene = eqx.tree_at(lambda s: s.objects, scene, tuple(o for o in scene.objects if o.name == "ball"))
    sky = jax.tree.map(lambda a: a.astype(scene.dtype), dw.GradientBackground((0.1, 0.2, 0.6), (0.9, 0.7, 0.2)))
    return eqx.tree_at(lambda s: s.background, scene, sky)


SCENES = {"spheres": spheres, "glass alone": glass_alone, "smooth": smooth}


def changed(scene, index, across):
    """The scene with this index of the glass, its sphere `across` metres from the middle."""
    scene = dw.replace_coefficient(scene, INDEX, jnp.asarray(index, scene.dtype))
    centre = jnp.zeros(3, scene.dtype).at[0].set(jnp.asarray(across, scene.dtype))
    return eqx.tree_at(lambda s: next(o for o in s.objects if o.name == "ball").centre, scene, centre)


def places(count, seed=0):
    """Well spread places in a pixel (Roberts 2018, R2 sequence)."""
    root = 1.32471795724474602596
    start = np.random.default_rng(seed).random(2)
    return ((start + np.arange(1, count + 1)[:, None] / [root, root**2]) % 1).astype(np.float32)


@eqx.filter_jit
def _total(tables, camera, plan, spots):
    number = jnp.int32(0)

    def one(total, spot):
        film, _, descendants = trace(tables, camera, plan, grid(plan, camera, number, spot))
        return total + film.stacked(axis=-1), descendants

    total, needed = jax.lax.scan(one, jnp.zeros((plan.pass_pixels, 3), tables.cutoff.dtype), spots)
    return total, needed.max()


def area_true(scene, camera, side, seed=0):
    """The mean of side * side points a pixel, summed in float64; side is a multiple of 8."""
    plan = make_plan(scene, camera, footprint=0, capacity=4 * camera.width * camera.height)
    assert plan.passes == 1
    tables, total = tables_of(scene, plan), 0  # outside the program, where every weight may be zero
    for spots in places(side * side, seed).reshape(-1, 64, 2):
        part, needed = _total(tables, camera, plan.program, jnp.asarray(spots))
        assert needed <= plan.capacity
        total = total + np.asarray(part, np.float64)
    return (total / side**2)[: camera.width * camera.height].reshape(camera.height, camera.width, 3)


def reference(make, camera, step, side, seed=0):
    """Image and central difference of converged images: the same points in both, so that only edges make noise."""
    below, above = (area_true(make(d), camera, side, seed) for d in (-step, step))
    return (below + above) / 2, (above - below) / (2 * step)


def filtered(scene, camera, index=1.5, across=0.0, along=(1.0, 0.0), trees=1, refine=False):
    """Image and derivative, in index and place of the sphere `along`, of `trees` x `trees` filtered trees a pixel."""
    found = dw.derivative(
        lambda step: changed(scene, index + along[0] * step, across + along[1] * step),
        0.0,
        camera,
        free=(INDEX,),
        footprint=trees,
        refine=refine,
    )
    return found.image.astype(np.float64), found.slope.astype(np.float64)


def cosine(a, b):
    return float((a * b).sum() / np.linalg.norm(a) / np.linalg.norm(b))


def relative(a, b):
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))
