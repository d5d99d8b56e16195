"""The ray tree: planned once, recorded without derivatives, replayed with them."""

from ._arrival import BRANCH_NAMES
from ._effects import EFFECT_NAMES, Decision, Effects, decide_effects
from ._film import film_of
from ._plan import Plan, likely_room, make_plan, unmeasured_plan
from ._record import Nodes, Record, record
from ._replay import replay, trace, trace_beside_small, trace_left_out
from ._samples import Samples, grid, pixel_of, sample_places
from ._truncation import Beyond

__all__ = [
    "BRANCH_NAMES",
    "Beyond",
    "EFFECT_NAMES",
    "Decision",
    "Effects",
    "Nodes",
    "Plan",
    "Record",
    "Samples",
    "decide_effects",
    "film_of",
    "grid",
    "likely_room",
    "make_plan",
    "pixel_of",
    "record",
    "replay",
    "sample_places",
    "trace",
    "trace_beside_small",
    "trace_left_out",
    "unmeasured_plan",
]
