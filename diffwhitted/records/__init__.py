"""How records are described: the rows of a record, the checks of its values, and the registries of kinds."""

from ._checks import (
    DEEPEST,
    check_file,
    depth_number,
    is_traced,
    listed,
    nearest_name,
    number_array,
    require,
    shortest,
    whole_number,
)
from ._copies import changed, grouped, in_dtype, member, member_count, members_at, moved, shifted, stacked
from ._registry import Registry
from ._row import REQUIRED, Row, entries, read_rows, rows_of
from ._scale import SCALES, Scale, typical_size

__all__ = [
    "DEEPEST", "REQUIRED", "SCALES", "Registry", "Row", "Scale", "changed", "check_file", "depth_number", "entries",
    "grouped", "in_dtype", "is_traced", "listed", "member", "member_count", "members_at", "moved", "nearest_name",
    "number_array", "read_rows", "require", "rows_of", "shifted", "shortest", "stacked", "typical_size",
    "whole_number",
]  # fmt: skip
