"""What accuracy costs in time: the knobs, any settings of them traced, and the cheapest that are accurate enough."""

from ._choose import Choice, Measured, choose, measure
from ._knobs import KNOBS, Knob, Settings

__all__ = ["Choice", "KNOBS", "Knob", "Measured", "Settings", "choose", "measure"]
