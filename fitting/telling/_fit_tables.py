"""The numbers of a fit as a table for a paper, from its `result.json`: value, standard error, 95 % interval."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from diffwhitted import InputError
from diffwhitted.formats import latex_table, markdown_table, plain_words

from ._tables import STATUS_WORDS, rounded, rounded_error

TABLES: dict[str, Callable[..., str]] = {"LaTeX": latex_table, "Markdown": markdown_table}
"""By the names of the formats of scenes."""


def read_result(path: Path) -> dict[str, Any]:
    """What a fit has left. Raises `InputError` for a file that is none."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        coefficients = content["coefficients"]
        if not isinstance(coefficients, dict) or not all("value" in c for c in coefficients.values()):
            raise TypeError
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; give the folder of a fit") from None
    except (ValueError, KeyError, TypeError):
        raise InputError(
            f"{path}: this is no result of a fit; give the result.json that `diffwhitted fit` wrote"
        ) from None
    return content


def fit_table(content: Mapping[str, Any], form: str) -> tuple[str, tuple[str, ...]]:
    """The table as text, and what it does not hold."""
    coefficients = content["coefficients"]
    with_units = any(c.get("unit", "1") != "1" for c in coefficients.values())
    remarks, rows = _about(content), []
    for name, c in coefficients.items():
        sure = c.get("identifiable", True)
        mark = ""
        if c.get("remark"):
            mark = "*"
            remarks.append(f"* {name}: {c['remark']}")
        unit = [_unit(c.get("unit", "1"))] if with_units else []
        rows.append([plain_words(name) + mark, _value(c, sure), *unit, _interval(c)])
    head = ["coefficient", r"value $\pm$ standard error", *["unit"] * with_units, "95 % interval"]
    text = TABLES[form](head, rows, list(map(plain_words, remarks)))
    return text, (f"{form}: correlations, bounds, steps and pictures of the fit are not in the table",)


def _about(content: Mapping[str, Any]) -> list[str]:
    """How the fit ended, in a line or two."""
    status = str(content.get("status", ""))
    said = [f"{STATUS_WORDS.get(status, status)}."] if status else []
    size = {"RMSE": content.get("rmse"), "noise": content.get("noise")}
    numbers = [f"{key} {value:.3g} linear RGB" for key, value in size.items() if isinstance(value, float)]
    return said + ([f"{', '.join(numbers)}."] if numbers else [])


def _value(c: Mapping[str, Any], sure: bool) -> str:
    """`0.1203 ± 0.0004`; in brackets what the pictures do not determine."""
    value, error = c.get("value"), c.get("standard_error")
    if value is None:
        return "not finite"
    text = _power(rounded(value, error))
    if error is not None:
        return rf"${text} \pm {_power(rounded_error(error))}$"
    return f"${text}$" if sure else f"$({text})$"


def _interval(c: Mapping[str, Any]) -> str:
    """`0.1195 to 0.1211`; one end where there is one; half the width where both read alike."""
    interval, error = c.get("interval_95"), c.get("standard_error")
    low, high = interval or (None, None)
    if low is None or high is None:
        end, sign = (low, r"\ge") if high is None else (high, r"\le")
        return "none" if end is None else f"${sign} {_power(rounded(end, error))}$"
    ends = [_power(rounded(end, error)) for end in (low, high)]
    return f"${ends[0]}$ to ${ends[1]}$" if ends[0] != ends[1] else rf"$\pm {_power(rounded_error((high - low) / 2))}$"


def _power(text: str) -> str:
    """1e-08 as a power of ten."""
    digits, e, power = text.partition("e")
    return rf"{digits} \times 10^{{{int(power)}}}" if e else digits


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit
