"""The ray tree: planned once, recorded without derivatives, replayed with them.

Four words stand throughout. Rays are followed in blocks; `needed` says whether any ray of a block is alive. A `stage`
is a piece of work whose results XLA writes down once, in place of repeating it in each of its uses; it is skipped where
it is not needed. `packed` work is gathered from the few rays that want it, and put back. `always` is a condition that
holds. See `numerics/_stage`.
"""

from ._arrival import BRANCH_NAMES
from ._asked import calls_for
from ._effects import (
    EFFECT_NAMES,
    Decision,
    Effect,
    Effects,
    decide_effects,
    effect_rows,
    including_effect,
)  # fmt: skip
from ._film import film_of
from ._fresnel import Passed
from ._idle import idle
from ._plan import Plan, likely_room, make_plan, tables_of, unmeasured_plan
from ._points import points_only, trees_or_points
from ._record import Nodes, Record, record
from ._replay import averaged, replay, trace, trace_beside_small, trace_left_out
from ._samples import Draw, Samples, drawn, grid, pixel_of, sample_places
from ._shadows import blocking
from ._sought import arrivals, sought
from ._truncation import Beyond

__all__ = [
    "BRANCH_NAMES", "EFFECT_NAMES", "Beyond", "Decision", "Draw", "Effect", "Effects", "Nodes", "Passed", "Plan",
    "Record", "Samples", "arrivals", "averaged", "blocking", "calls_for", "decide_effects", "drawn", "effect_rows",
    "film_of", "grid", "idle", "including_effect", "likely_room", "make_plan", "pixel_of", "points_only",
    "record", "replay", "sample_places", "sought", "tables_of", "trace", "trace_beside_small", "trace_left_out",
    "trees_or_points", "unmeasured_plan",
]  # fmt: skip
