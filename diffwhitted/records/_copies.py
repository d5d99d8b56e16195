"""Records of one kind as columns, and copies of records with other static fields."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..numerics._vector import lookup
from ._checks import is_traced
from ._row import rows_of

R = TypeVar("R", bound=eqx.Module)
T = TypeVar("T")


def changed(record: R, **new: Any) -> R:
    """A copy of a record with other values of some fields, static ones too, without the checks of its `__init__`."""
    copy = object.__new__(type(record))
    for field in fields(record):
        object.__setattr__(copy, field.name, new.get(field.name, getattr(record, field.name)))
    return copy


def in_dtype(record: R, dtype) -> R:
    """A copy of a record with its real numbers in another precision; whole numbers stay what they are.

    What is known stays on the host.
    """

    def cast(a):
        if a.dtype == dtype or not jnp.issubdtype(a.dtype, jnp.floating):
            return a
        return a.astype(dtype) if is_traced(a) else np.asarray(a).astype(dtype)

    return jax.tree.map(cast, record)


def moved(record: R, by: np.ndarray) -> R:
    """A copy of a record whose places (its rows of vectors in metres) are moved by so many metres, (3,).

    What is known is moved in float64, what is traced in its own precision.
    """
    places = [row.name for row in rows_of(record).values() if row.kind in ("vector", "vectors") and row.unit == "m"]
    stated = {name: value for name in places if (value := getattr(record, name)) is not None}
    return changed(record, **{name: shifted(value, by) for name, value in stated.items()})


def shifted(value, by):
    """The sum of a number of a record and of one of the host, in float64 where the record's is known."""
    return value + jnp.asarray(by, value.dtype) if is_traced(value) else np.asarray(value, np.float64) + by


def stacked(values: Sequence) -> Float[Array, "members ..."]:
    """Arrays of one shape as one array: on the host where all are concrete, with the traced ones put in where some
    are.
    """
    traced = [i for i, value in enumerate(values) if is_traced(value)]
    if not values:
        return jnp.zeros(0)
    if len(traced) == len(values):
        return jnp.stack(values)
    blank = next(value for value in values if not is_traced(value))
    rows = jnp.asarray(np.stack([np.asarray(blank if is_traced(value) else value) for value in values]))
    return rows.at[np.asarray(traced)].set(jnp.stack([values[i] for i in traced])) if traced else rows


def grouped(records: Sequence[R]) -> tuple[tuple[R, ...], np.ndarray]:
    """Records of one structure (kind, static fields but the name, shapes) stacked into one, and the number of each
    record in the order of the groups.
    """
    groups: dict = {}
    for number, record in enumerate(records):
        bare = changed(record, name="") if any(field.name == "name" for field in fields(record)) else record
        leaves, structure = jax.tree.flatten(bare)
        key = structure, tuple(np.shape(leaf) for leaf in leaves)
        groups.setdefault(key, []).append((number, leaves))
    together = tuple(
        jax.tree.unflatten(key[0], [stacked(column) for column in zip(*(leaves for _, leaves in members), strict=True)])
        for key, members in groups.items()
    )
    order = np.zeros(len(records), np.int32)
    order[[number for members in groups.values() for number, _ in members]] = np.arange(len(records))
    return together, order


def member_count(group) -> int:
    """How many records a stacked one holds."""
    return jax.tree.leaves(group)[0].shape[0]


def member(group: R, number) -> R:
    """One of the stacked records, by a whole number or a scalar array."""
    return jax.tree.map(lambda column: column[number], group)


def members_at(group: T, index) -> T:
    """For each ray the record that it needs: every field has the rays as its leading axis, column by column."""

    def field(column):
        if column.shape[0] == 1:
            return column[0]
        flat = column.reshape(column.shape[0], -1)
        found = [lookup(flat[:, k], index) for k in range(flat.shape[1])]
        return jnp.stack(found, axis=-1).reshape(*index.shape, *column.shape[1:])

    return jax.tree.map(field, group)
