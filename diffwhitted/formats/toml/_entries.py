"""Tables of a scene file as models, read into records and written from them."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, get_args

import numpy as np
from pydantic import BaseModel, create_model

from ..._errors import SceneError
from ...records import Registry, Row, shortest
from ...shapes import POSE, VELOCITY
from ._keys import KEYS, key, optional


def written(array):
    """Python numbers, as short as the precision of the array allows, that read back to the same bits."""
    array = np.asarray(array)
    if array.dtype.kind in "iu":
        return array.tolist()
    if array.ndim:
        return [written(part) for part in array]
    one = array[()]
    short = shortest(one)
    return short if array.dtype.type(short) == one else float(one)


def _listed(value) -> Any:
    """Lists of lists of whole numbers as they are."""
    return [list(part) for part in value] if isinstance(value, tuple) else written(value)


class Entry(BaseModel):
    """One table of the file; `made` is the record that it stands for."""

    model_config = KEYS
    made: ClassVar[type]
    tables: ClassVar[dict[str, type[BaseModel]]] = {}
    """Inline tables of keys that belong together, by their names."""
    takes_name: ClassVar[bool] = False
    """The record holds its own name."""

    def record(self, place: str, dtype):
        """The record, its arrays of `dtype`; raises `SceneError`, which begins with `place`."""
        left_out = {"type"} if self.takes_name else {"type", "name"}
        fields = [field for field in type(self).model_fields if field not in left_out]
        stated = {field: self.value(field, place, dtype) for field in fields if getattr(self, field) is not None}
        for table in [field for field, value in stated.items() if isinstance(value, Entry)]:
            inner = stated.pop(table)
            keys = [key for key in type(inner).model_fields if getattr(inner, key) is not None]
            stated |= {f"{table}_{key}": inner.value(key, f"{place}: {table}", dtype) for key in keys}
        return self.made(place=place, **stated)

    def value(self, field: str, place: str, dtype) -> Any:
        """The value of a field: numbers as an array, text and counts as they are."""
        value = getattr(self, field)
        if not isinstance(value, (float, list)) or field == "faces":
            return value
        with np.errstate(over="ignore"):
            array = np.asarray(value, dtype)
        if not np.isfinite(array).all():
            largest = np.ravel(value)[np.abs(value).argmax()]
            raise SceneError(
                f"{place}: {field} = {largest:g} is too large for {dtype.name}; allowed is up to "
                f"{np.finfo(dtype).max:.3g}. Write the scene in a larger unit, or read it as float64"
            )
        # With all the digits of the file: the scene decides on the precision.
        return np.asarray(value, np.float64)

    @classmethod
    def plain(cls, record, **stated) -> dict:
        """The table for a record, as Python numbers and text; `stated` are the keys that it does not hold."""
        if "type" in cls.model_fields:
            stated = {"type": get_args(cls.model_fields["type"].annotation)[0]} | stated
        for name, table in cls.tables.items():
            inner = {key: getattr(record, f"{name}_{key}") for key in table.model_fields}
            stated[name] = {key: written(value) for key, value in inner.items() if value is not None} or None
        held = {field: getattr(record, field, None) for field in cls.model_fields if field not in stated}
        values = stated | {
            field: value if isinstance(value, (str, int, dict)) else _listed(value)
            for field, value in held.items()
            if value is not None
        }
        return {field: values[field] for field in cls.model_fields if values.get(field) is not None}


class MaterialEntry(Entry):
    """One material: what is not stated is for its class to say."""

    def record(self, place: str, dtype):
        stated = {field: self.value(field, place, dtype) for field in self.model_fields_set if field != "name"}
        if isinstance(table := stated.get("dispersion"), BaseModel):
            stated["dispersion"] = table.model_dump(exclude_none=True)
        return self.made(place=place, **{field: value for field, value in stated.items() if value is not None})


class ObjectEntry(Entry):
    """One object, and where it is placed."""

    def record(self, place: str, dtype):
        fields = [field for field in type(self).model_fields if field != "type" and getattr(self, field) is not None]
        stated = {field: self.value(field, place, dtype) for field in fields}
        pose = {row.name: stated.pop(row.name) for row in POSE if row.name in stated}
        velocity = stated.pop(VELOCITY.name, None)
        thing = self.made(place=place, **stated).moving(velocity, place)
        return thing.placed(**pose, place=place) if pose else thing


def entry(
    table: str, kind, rows: tuple[Row, ...], takes_name: bool = False, base: type[Entry] = Entry, **keys
) -> type[Entry]:
    """The model of the table of a kind."""
    first = {name: keys.pop(name) for name in ("name", "type") if name in keys}
    tables = _tables(rows)
    mine = {row.name: key(row) for row in rows if row.kind != "texels" and not row.table}
    inline = {
        name: (model, optional(f"A table of any of {', '.join(model.model_fields)}.")) for name, model in tables.items()
    }
    fields: dict[str, Any] = first | mine | inline | keys
    meaning = (kind.__doc__ or "").strip().split("\n\n")[0].replace("\n    ", " ")
    made = create_model(f"{table.capitalize()}Entry", __base__=base, __doc__=meaning, **fields)
    made.made, made.takes_name, made.tables = kind, takes_name, tables
    return made


def _tables(rows: tuple[Row, ...]) -> dict[str, type[Entry]]:
    """The inline tables of a record, by their names: of the rows that say that they stand in one."""
    found = {}
    for name in dict.fromkeys(row.table for row in rows if row.table):
        keys: dict[str, Any] = {row.name.removeprefix(f"{name}_"): key(row) for row in rows if row.table == name}
        listed = ", ".join(keys)
        found[name] = create_model(
            f"{name.capitalize()}Table", __base__=Entry, __doc__=f"{name.capitalize()}: {listed}.", **keys
        )
    return found


def entries(
    registry: Registry,
    takes_name: bool,
    default: str | None = None,
    base: type[Entry] = Entry,
    bases: Mapping[type, type[Entry]] | None = None,
    beside: Mapping[str, type[Entry]] | None = None,
    **keys,
) -> dict[str, type[Entry]]:
    """The models of a family, by the type that a file states, or that it need not state; `bases`: those of kinds whose
    table is not their rows alone; `beside`: another family, whose types may have the same names.
    """

    def model(name: str, kind, rows) -> type[Entry]:
        stated = (Literal[name], name if name == default else ...)
        title = f"{name}_{registry.family}" if name in (beside or {}) else name
        return entry(title, kind, rows, takes_name, (bases or {}).get(kind, base), **keys, type=stated)

    return {
        name: model(name, kind, rows) for kind in registry for name, rows in {kind.TYPE: kind.ROWS, **kind.ALSO}.items()
    }
