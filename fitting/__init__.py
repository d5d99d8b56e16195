"""From pictures to materials: fit coefficients of a scene to target images, with uncertainties."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._errors import FitError
    from ._fit import fit
    from ._fit_texture import TextureFit, fit_texture
    from ._held_out import HeldOut
    from ._result import FitResult, FitStage, FitStep, FittedCoefficient, FitView, WildPixel
    from .comparing._tradeoff import Tradeoff, tradeoff
    from .comparing._tradeoff_plot import tradeoff_figure
    from .planning._identification import Identification
    from .planning._identify import identify
    from .planning._suggest import Suggestion, suggest
    from .problem._only import only
    from .problem._target import Target

__all__ = [
    "FitError",
    "FitResult",
    "FitStage",
    "FitStep",
    "FitView",
    "FittedCoefficient",
    "HeldOut",
    "Identification",
    "Suggestion",
    "Target",
    "TextureFit",
    "Tradeoff",
    "WildPixel",
    "fit",
    "fit_texture",
    "identify",
    "only",
    "suggest",
    "tradeoff",
    "tradeoff_figure",
]

_HOMES = {
    "FitError": "_errors",
    "FitResult": "_result",
    "FitStage": "_result",
    "FitStep": "_result",
    "FitView": "_result",
    "FittedCoefficient": "_result",
    "HeldOut": "_held_out",
    "Identification": "planning._identification",
    "Suggestion": "planning._suggest",
    "Target": "problem._target",
    "TextureFit": "_fit_texture",
    "Tradeoff": "comparing._tradeoff",
    "WildPixel": "_result",
    "fit": "_fit",
    "fit_texture": "_fit_texture",
    "identify": "planning._identify",
    "only": "problem._only",
    "suggest": "planning._suggest",
    "tradeoff": "comparing._tradeoff",
    "tradeoff_figure": "comparing._tradeoff_plot",
}


def __getattr__(name: str):
    """Import a name when it is asked for: the command line must not wait for optimistix to print its help."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
