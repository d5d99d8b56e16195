"""Numbers that become colours: where the scene has one number for all channels, and a fit looks for three."""

import fnmatch
from collections.abc import Sequence

import numpy as np

from diffwhitted.scene import Parameter, Scene, parameters

from .._errors import FitError
from ._free_names import match_parameters

CHANNELS = ("r", "g", "b")


def coloured(scene: Scene, colour: Sequence[str], free: Sequence[str] = ()) -> Scene:
    """The scene with three numbers in place of one for each name in `colour` (wildcards allowed), and for each channel
    among the free names. The picture stays as it was.

    Raises `FitError` for a name that matches nothing, and for what is no colour.
    """
    there, chosen = parameters(scene), []
    for pattern in (colour,) if isinstance(colour, str) else colour:
        found, plain = match_parameters(scene, there, pattern)
        able = [p for p, component in found if _may_be(p) and not component]
        if not able:
            raise FitError(f"colour: {pattern}: {found[0][0].name} is never three channels; name a k_a, k_d, k_h, ...")
        chosen += able
    for pattern in (free,) if isinstance(free, str) else free:
        stem, _, channel = pattern.rpartition(".")
        if channel in CHANNELS:
            chosen += [p for p in there if _may_be(p) and _is_named(p, stem)]
    for parameter in dict.fromkeys(chosen):
        if np.ndim(parameter.value(scene)) == 0:
            scene = parameter.replaced(scene, np.full(3, np.asarray(parameter.value(scene))))
    return scene


def is_grey(scene: Scene, parameter: Parameter) -> bool:
    """Is it one number in the scene, and could be a colour?"""
    return _may_be(parameter) and np.ndim(parameter.value(scene)) == 0


def _may_be(parameter: Parameter) -> bool:
    return parameter.row.kind == "number or colour"


def _is_named(parameter: Parameter, pattern: str) -> bool:
    names = {parameter.name} | ({f"material.{parameter.name}"} if parameter.family == "material" else set())
    return pattern in names or (
        parameter.family in ("material", pattern.partition(".")[0])
        and any(fnmatch.fnmatchcase(name, pattern) for name in names)
    )
