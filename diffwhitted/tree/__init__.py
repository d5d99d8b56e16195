"""The ray tree: planned once, recorded without derivatives, replayed with them."""

from ._branch import BRANCH_NAMES
from ._effects import EFFECT_NAMES, Decision, Effects, decide_effects
from ._plan import PIXELS_PER_PASS, Plan, make_plan
from ._record import Nodes, Record, record
from ._replay import replay

__all__ = [
    "BRANCH_NAMES", "EFFECT_NAMES", "PIXELS_PER_PASS", "Decision", "Effects", "Nodes", "Plan", "Record",
    "decide_effects", "make_plan", "record", "replay",
]
