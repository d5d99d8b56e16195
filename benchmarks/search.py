"""Many surfaces: the sphereflake and meshes against POV-Ray, the search in JAX, closed meshes, and building."""

import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import diffwhitted
from diffwhitted.accuracy._reference import rmse
from diffwhitted.formats import with_files
from diffwhitted.geometry import NOTHING, Departure, Ray, _compiled, nearest
from diffwhitted.numerics._vector import vec3
from diffwhitted.scene import tabulate

from . import _povray
from ._figures import Figure
from ._fresh import peak_memory, run
from ._many import bumpy, mirror_ball
from ._timing import Seconds, timed

ROUNDS, RENDERS_A_ROUND = 5, 3
AIMED = 2_000_000


def measure() -> list[Figure]:
    small = _against_povray("sphereflake, 91 spheres, 512x512", diffwhitted.standard_scene("balls", 2), None)
    large = _against_povray("sphereflake, 7381 spheres, 512x512", diffwhitted.standard_scene("balls", 4), 0.5)
    growth, theirs = _growth(large[0], small[0]), _growth(large[1], small[1]) if len(large) > 1 else None
    said = f"POV-Ray's {theirs:.3g}" if theirs else _povray.MISSING
    found = [*small, *large, Figure("time of 7381 spheres / of 91", growth, "", 2.3, said)]
    found += _against_povray("mirror of 81 920 triangles, 640x480", mirror_ball(6), 0.6)
    with _without_machine_code():
        found += _against_povray("the same, searched in JAX", mirror_ball(6), 1.5)
    return [*found, *_closed(), *_built()]


def _growth(large: Figure, small: Figure) -> float:
    return (large.value or 0.0) / (small.value or np.inf)


def _against_povray(name: str, scene: diffwhitted.Scene, goal: float | None) -> list[Figure]:
    camera = scene.cameras["main"]
    plan = diffwhitted.plan(scene, camera)

    def render():
        return diffwhitted.render(scene, camera, plan=plan)

    image = np.asarray(jax.block_until_ready(render()))
    if not _povray.available():
        ours = Seconds(tuple(timed(render) for _ in range(ROUNDS * RENDERS_A_ROUND)))
        return [Figure(name, ours.median, "s", None, f"{ours}; {_povray.MISSING}")]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.pov"
        diffwhitted.save_scene(scene, file)
        turns = []
        for _ in range(ROUNDS):
            theirs = _povray.trace(file, camera.width, camera.height)
            turns.append((theirs, Seconds(tuple(timed(render) for _ in range(RENDERS_A_ROUND)))))
    povray = Seconds(tuple(theirs.seconds for theirs, _ in turns))
    whole = Seconds(tuple(t for _, ours in turns for t in ours.runs))
    ratio = float(np.median([ours.median / theirs.seconds for theirs, ours in turns]))
    off = abs(image - turns[0][0].pixels).max(axis=-1)
    said = f"{rmse(image, turns[0][0].pixels):.2g} RMSE; {np.mean(off > 0.02):.2%} of the pixels differ by over 0.02"
    return [
        Figure(name, whole.median, "s", None, f"{whole}; {said}"),
        Figure(f"{name}: POV-Ray's trace time", povray.median, "s", None, f"{povray}; two threads"),
        Figure(f"{name} / POV-Ray", ratio, "", goal, f"{whole.shortest / povray.shortest:.3g} of the shortest runs"),
    ]


@contextmanager
def _without_machine_code() -> Iterator[None]:
    """As on a machine without numba."""
    found = _compiled._machine
    _compiled._machine = lambda: None  # pyright: ignore[reportAttributeAccessIssue]
    try:
        jax.clear_caches()
        yield
    finally:
        _compiled._machine = found
        jax.clear_caches()


def _closed() -> list[Figure]:
    """Rays from inside a closed mesh, aimed at its sides and corners: how many find a way out."""
    vertices, faces = bumpy(5)
    scene = diffwhitted.Scene(
        objects=[diffwhitted.Mesh("ball", vertices, faces, "m")], materials={"m": diffwhitted.Material()}
    )
    rng = np.random.default_rng(1)
    origin = rng.uniform(-0.4, 0.4, (AIMED, 3)).astype(np.float32)
    ends = vertices.astype(np.float32)[faces[rng.integers(0, len(faces), AIMED)]]
    share = np.where(rng.random((AIMED, 1)) < 0.3, 0, rng.random((AIMED, 1))).astype(np.float32)
    aim = ends[:, 0] * (1 - share) + ends[:, 1] * share - origin
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    ray = Ray(vec3(jnp.asarray(origin)), vec3(jnp.asarray(aim)))
    free = Departure(jnp.full(AIMED, NOTHING, jnp.int32), jnp.zeros(AIMED, bool))

    def lost():
        shapes = tabulate(scene).shapes
        return float((np.asarray(jax.jit(nearest)(shapes, ray, free)[1]) < 0).sum())

    machine = lost()
    with _without_machine_code():
        walked = lost()
    said = f"of {AIMED:,} aimed at sides and corners of {len(faces):,} triangles"
    return [
        Figure("rays that leave a closed mesh, machine code", machine, "", 0, said),
        Figure("rays that leave a closed mesh, JAX", walked, "", 0, said),
    ]


def _built() -> list[Figure]:
    """A mesh of 1.3 million triangles: read, made, planned and its tree built, and the most memory until then."""
    with tempfile.TemporaryDirectory() as folder:
        mesh, paint = diffwhitted.Mesh("ball", *bumpy(8), "m"), {"m": diffwhitted.Material()}
        _, beside = with_files(diffwhitted.Scene(objects=[mesh], materials=paint), Path(folder) / "ball.toml")
        ((file, data),) = beside.items()
        file.write_bytes(data)
        begun = time.perf_counter()
        scene = diffwhitted.Scene(
            objects=[diffwhitted.Mesh("ball", material="m", file=str(file))],
            materials={"m": diffwhitted.Material(k_d=0.7)},
            lights=[diffwhitted.PointLight((3, 4, 3), (1, 1, 1))],
        )
        camera = diffwhitted.Camera((0, 1.2, 4.2), (0, 0, 0), 40, 64, 48)
        jax.block_until_ready(tabulate(scene))
        seconds = time.perf_counter() - begun
        first = timed(lambda: diffwhitted.render(scene, camera))
    return [
        Figure("read and build 1.3 M triangles", seconds, "s", 12, f"then {first:.3g} s to the first 64x48 pixels"),
        Figure(
            "most memory of the process until then",
            peak_memory(),
            "GiB",
            1.5,
            "with all that this benchmark did before",
        ),
    ]


if __name__ == "__main__":
    run("search", measure)
