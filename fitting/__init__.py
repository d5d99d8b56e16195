"""From pictures to materials: fit coefficients of a scene to target images, with uncertainties."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._errors import FitError
    from ._fit import fit
    from ._result import FitResult, FitStep, FittedCoefficient, FitView
    from ._target import Target

__all__ = ["FitError", "FitResult", "FitStep", "FitView", "FittedCoefficient", "Target", "fit"]

_HOMES = {"FitError": "_errors", "FitResult": "_result", "FitStep": "_result", "FitView": "_result",
          "FittedCoefficient": "_result", "Target": "_target", "fit": "_fit"}


def __getattr__(name: str):
    """Import what is asked for when it is asked for: the command line must not wait for optimistix to print its help."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
