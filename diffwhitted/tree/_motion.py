"""Motion blur: each sample of a pixel has its time, at which all of the scene is traced (Cook et al. 1984, section 3.5;
Haeberli and Akeley 1990).
"""

from dataclasses import replace

from ..scene import AbstractCamera, Tables
from ._chance import IN_TIME, mixed, places
from ._dispersion import at_band
from ._plan import Plan
from ._samples import Samples


def as_drawn(tables: Tables, camera: AbstractCamera, plan: Plan, samples: Samples) -> tuple[Tables, AbstractCamera]:
    """Tables and camera as these samples see them: with the indices of their band, and where motion has taken them."""
    tables = at_band(tables, plan, samples)
    if not plan.effects.motion or camera.shutter is None:
        return tables, camera
    time = camera.shutter * _instant(tables, plan, samples, camera.shutter.dtype)
    camera = camera.after(time)
    if tables.motion is None:
        return tables, camera
    motion = tables.motion
    return replace(tables, shapes=motion.at(tables.shapes, time), shift=motion.shift(time)), camera


def _instant(tables: Tables, plan: Plan, samples: Samples, dtype):
    """The time of the samples, from -1/2 to 1/2 of what the shutter is open.

    Every other sample is as long after the middle as the one before is before it, as its place in the lens is opposite
    to that: what is linear in the time has its mean exactly.
    """
    number = samples.draw // plan.bands
    (time,) = places(mixed(tables.seed), number // 2, IN_TIME, dtype)
    return (time - 0.5) * (1 - 2 * (number % 2)).astype(dtype)
