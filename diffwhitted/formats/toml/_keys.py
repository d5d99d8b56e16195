"""The kinds of keys that a scene file may hold, from the rows of the records."""

import math
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Discriminator, Field, Tag

from ...records import REQUIRED, Row


def number(**limits):
    """A finite number; the limits serve the JSON Schema."""
    return Annotated[float, Field(allow_inf_nan=False, json_schema_extra=limits or None)]


def listed(item, shortest: int, longest: int | None = None):
    return Annotated[list[item], Field(min_length=shortest, max_length=longest)]


def or_colour(one):
    """A number, or linear RGB; the kind of the value decides which of the two is checked."""
    return Annotated[
        Annotated[one, Tag("number")] | Annotated[listed(one, 3, 3), Tag("colour")],
        Discriminator(lambda value: "colour" if isinstance(value, list) else "number"),
    ]


def optional(description: str, **limits) -> Any:
    """A key that may be absent; TOML has no null, so the JSON Schema states no default, but the limits of a number."""

    def stated(schema):
        schema.pop("default", None)
        schema.update(limits)

    return Field(None, description=description, json_schema_extra=stated)


KEYS = ConfigDict(
    extra="forbid",
    strict=True,
    field_title_generator=lambda key, _: key,
    model_title_generator=lambda model: model.__name__.removesuffix("Entry").lower(),
)
Colour = listed(number(minimum=0), 3, 3)
Name = Annotated[str, Field(min_length=1)]
Vector = listed(number(), 3, 3)
Pixels = Annotated[int, Field(json_schema_extra={"minimum": 1, "maximum": 32768})]
ObjectName = Annotated[Name, Field(description="Name of the object, one of a kind.")]
MaterialName = Annotated[str, Field(description="Name of a material of this file.")]


def key(row: Row) -> tuple[Any, Any]:
    """The type of a row's value in a file, and the field with its default."""
    extra = {"pattern": row.pattern} if row.pattern else None
    described: dict[str, Any] = {"description": row.meaning} | ({"json_schema_extra": extra} if extra else {})
    if row.default is None:
        # A type and a key cannot both say what the JSON Schema has besides.
        alone = {"number": number(), "count": int}.get(row.kind)
        return _type(row) if alone is None else alone, optional(row.meaning, **({} if alone is None else _limits(row)))
    default = list(row.default) if isinstance(row.default, tuple) else row.default
    return _type(row), Field(**described) if row.default is REQUIRED else Field(default, **described)


def _type(row: Row):
    """What a value must be."""
    one = number(**_limits(row))
    match row.kind:
        case "number":
            return one
        case "vector" | "direction" | "colour":
            return listed(one, 3, 3)
        case "numbers":
            return listed(one, len(row.parts), len(row.parts))
        case "number or colour" | "number or vector":
            return or_colour(one)
        case "matrix":
            return listed(listed(one, 4, 4), 4, 4)
        case "faces":
            return listed(listed(int, 3), *row.count)
        case "flag":
            return bool
        case "count":
            return Annotated[int, Field(json_schema_extra={name: int(end) for name, end in _limits(row).items()})]
        case "vectors" | "colours":
            vectors = listed(listed(one, 3, 3), *row.count)
            return Annotated[vectors, BeforeValidator(_one_after_the_other)] if row.grid else vectors
        case "pairs":
            return listed(listed(one, 2, 2), *row.count)
        case "list":
            return Annotated[
                Annotated[one, Tag("number")] | Annotated[listed(one, *row.count), Tag("list")],
                Discriminator(lambda value: "list" if isinstance(value, list) else "number"),
            ]
        case "faces":
            return listed(listed(int, 3), *row.count)
        case "choice":
            return Literal[row.choices]
    return str


def _one_after_the_other(value):
    """Rows of vectors, however deep, as one list of vectors."""
    while isinstance(value, list) and all(
        isinstance(row, list) and row and all(isinstance(one, list) for one in row) for row in value
    ):
        value = [one for row in value for one in row]
    return value


def _limits(row: Row) -> dict[str, float]:
    """The interval as the JSON Schema states it."""
    low, high = ("exclusiveMinimum", "exclusiveMaximum") if row.excluded else ("minimum", "maximum")
    ends = {low: row.lowest, high: row.highest}
    return {name: end for name, end in ends.items() if math.isfinite(end)}
