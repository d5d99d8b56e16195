"""The whole render, warm, against POV-Ray and Mitsuba 3 on the same scene: time, rays, and error beside it."""

import jax
import numpy as np

import diffwhitted
from diffwhitted.accuracy._reference import rmse

from . import _mitsuba, _povray
from ._figures import Figure
from ._fresh import run
from ._scene import CAMERA, POVRAY_FILE, three_spheres
from ._timing import Seconds, timed

ROUNDS, RENDERS_A_ROUND = 9, 5


def measure() -> list[Figure]:
    scene = three_spheres()
    camera = scene.cameras[CAMERA]
    plan = diffwhitted.plan(scene, camera)

    def render():
        return diffwhitted.render(scene, camera, plan=plan)

    image = np.asarray(jax.block_until_ready(render()))
    return [*_against_povray(scene, camera, render, image), *_against_mitsuba(render)]


def _against_povray(scene, camera, render, image) -> list[Figure]:
    if not _povray.available():
        return [
            _time(Seconds(tuple(timed(render) for _ in range(ROUNDS * RENDERS_A_ROUND)))),
            Figure("time / POV-Ray's trace time", None, "", 0.35, _povray.MISSING),
        ]
    runs, ours = [], []
    for _ in range(ROUNDS):
        runs.append(_povray.trace(POVRAY_FILE, camera.width, camera.height))
        ours.append(Seconds(tuple(timed(render) for _ in range(RENDERS_A_ROUND))))
    whole = Seconds(tuple(t for turn in ours for t in turn.runs))
    povray = Seconds(tuple(r.seconds for r in runs))
    by_round = np.asarray([turn.median for turn in ours]) / povray.runs
    return [
        _time(whole),
        Figure("POV-Ray's own trace time", povray.median, "s", None, f"{povray}; two threads"),
        Figure(
            "time / POV-Ray's trace time",
            float(np.median(by_round)),
            "",
            0.35,
            f"median over {ROUNDS} rounds; {whole.shortest / povray.shortest:.3g} of the shortest runs",
        ),
        *_same_rays(scene, camera, runs[0]),
        *_same_picture(image, runs[0].pixels),
    ]


def _time(whole: Seconds) -> Figure:
    return Figure("render 640x480, depth 5", whole.median, "s", None, str(whole))


def _same_rays(scene, camera, reference: _povray.Traced) -> list[Figure]:
    """POV-Ray counts a ray past the depth limit too, when it is sent and before it returns black."""
    counted = diffwhitted.explain(scene, camera, measure=False).rays
    sent = {kind: counted.by_kind[kind] + counted.cut_off.get(kind, 0) for kind in counted.by_kind}
    ours = {"all": sum(sent.values()), "mirror": sent["mirror"] + sent["total"], "transmitted": sent["transmitted"]}
    return [
        Figure(
            f"{kind} rays, difference from POV-Ray",
            100 * abs(ours[kind] / count - 1),
            "%",
            2.0,
            f"{ours[kind]} against {count}",
        )
        for kind, count in reference.counts.items()
    ]


def _same_picture(image, reference) -> list[Figure]:
    """The root mean square difference, over all pixels and without those at an edge in either picture."""
    inside = ~(_edges(image) | _edges(reference))
    return [
        Figure(
            "RMSE against POV-Ray, away from edges",
            rmse(image[inside], reference[inside]),
            "",
            0.002,
            f"{inside.mean():.0%} of the pixels; {rmse(image, reference):.2g} over all; linear RGB, half-float "
            "reference",
        )
    ]


def _edges(image, step: float = 0.05):
    """Pixels that differ by more than `step` from one beside them."""
    across = np.abs(np.diff(image, axis=1)).max(axis=2) > step
    down = np.abs(np.diff(image, axis=0)).max(axis=2) > step
    edge = np.zeros(image.shape[:2], bool)
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


def _against_mitsuba(render) -> list[Figure]:
    found = _mitsuba.ask("render")
    if isinstance(found, str):
        return [Figure("Mitsuba 3, one sample a pixel", None, "s", None, found)]
    ours = Seconds(tuple(timed(render) for _ in range(ROUNDS)))
    theirs = Seconds(tuple(found["seconds"]))
    needed = (found["noise"] / 0.002) ** 2
    return [
        Figure(
            "Mitsuba 3, one sample a pixel",
            theirs.median,
            "s",
            None,
            f"{theirs}; {found['version']} {found['variant']}; noise {found['noise']:.2g} RMS in linear RGB "
            f"(about {needed:.0f} samples a pixel to come down to 0.002)",
        ),
        Figure(
            "time / Mitsuba 3, one sample a pixel",
            ours.median / theirs.median,
            "",
            None,
            f"{ours.shortest / theirs.shortest:.3g} of the shortest runs; its picture is a path-traced one of the "
            "same shapes",
        ),
    ]


if __name__ == "__main__":
    run("forward", measure)
