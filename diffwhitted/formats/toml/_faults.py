"""What is wrong with a scene file, in sentences: the place, the value, what is allowed, what to try.

What is allowed is read from the JSON Schema of the file, so that a message and an editor say the same.
"""

import difflib
import json
from collections.abc import Iterable

from pydantic import ValidationError

from ..._errors import SceneError
from ._elsewhere import elsewhere
from ._schema import scene_schema

SHOWN = 5
"""Faults listed in one message."""


def scene_error(source: str, faults: list[str]) -> SceneError:
    """One error for all faults of a file; the first few are listed."""
    if len(faults) == 1:
        return SceneError(f"{source}: {faults[0]}")
    more = [f"and {len(faults) - SHOWN} more"] if len(faults) > SHOWN else []
    return SceneError("\n  ".join([f"{source}: {len(faults)} faults", *faults[:SHOWN], *more]))


def place(table: str, index: int | None = None, name=None) -> str:
    """Such as 'object "ball" (3rd [[object]])'; a table without a name is '3rd [[light]]'."""
    if index is None:
        return table
    number = f"{ordinal(index + 1)} [[{table}]]"
    return f"{table} {shown(name)} ({number})" if isinstance(name, str) else number


def ordinal(number: int) -> str:
    """1st, 2nd, 3rd, 4th, 11th, 21st."""
    teens = number % 100 in (11, 12, 13)
    return f"{number}{'th' if teens else {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10, 'th')}"


def shown(value) -> str:
    """A value as a TOML file would state it, cut where it is long."""
    match value:
        case bool():
            text = str(value).lower()
        case int() if abs(value) >= 10**40:
            text = f"a whole number of {value.bit_length()} bits"
        case str():
            text = json.dumps(value, ensure_ascii=False)
        case list():
            text = "[" + ", ".join(map(shown, value[:12])) + (", ..." if len(value) > 12 else "") + "]"
        case dict():
            text = "{ " + ", ".join(f"{key} = {shown(part)}" for key, part in list(value.items())[:4]) + " }"
        case _:
            text = str(value)
    return text if len(text) <= 80 else text[:76] + " ..."


def faults_of(error: ValidationError, document: dict) -> list[str]:
    """A sentence for each fault that the models found; a missing key is not named beside its misspelling."""
    schema, faults, meant = scene_schema(), [], set()
    for fault in sorted(error.errors(), key=lambda fault: fault["type"] == "missing"):
        path, value, node = _descend(fault["loc"], document, schema)
        if fault["type"] == "extra_forbidden":
            likely, said = _meant(path, node["properties"])
            meant.add((*path[:-1], likely))
            faults.append(_unknown_key(path, value, likely, said, node, document))
        elif fault["type"] != "missing" or tuple(path) not in meant:
            faults.append(_wrong(fault["type"], path, value, node, document))
    return faults


def _descend(loc: tuple, document: dict, schema: dict):
    """Path, value and schema of a fault; a value that may be of several kinds is taken as a whole."""
    path, value, node = [], document, schema
    for part in loc:
        if "oneOf" in node:
            tables = [kind for kind in (_resolved(kind, schema) for kind in node["oneOf"]) if kind["type"] == "object"]
            tables = tables if len(tables) == 1 else [kind for kind in tables if _is_called(kind, part)]
            if not (tables and isinstance(value, dict)):
                break
            node = tables[0]
            continue
        path.append(part)
        known = node["type"] == "array" or part in node["properties"]
        value = value.get(part) if isinstance(value, dict) else value and value[part]
        if not known:
            break
        node = _resolved(node["items"] if node["type"] == "array" else node["properties"][part], schema)
    if "oneOf" in node:
        node = node | {"oneOf": [_resolved(kind, schema) for kind in node["oneOf"]]}
    return path, value, node


def _is_called(kind: dict, tag) -> bool:
    """Is a table of this type, or the one without a type that is known by this key?"""
    const = kind["properties"].get("type", {}).get("const")
    return tag in kind["properties"] if const is None else tag == const


def _resolved(node: dict, schema: dict) -> dict:
    return schema["$defs"][node["$ref"].rsplit("/", 1)[-1]] if "$ref" in node else node


def _wrong(kind: str, path: list, value, node: dict, document: dict) -> str:
    if len(path) == 1 and node["type"] == "string":
        table = path[0].removesuffix("s")
        guess = f" Did you mean [[{table}]]?" if isinstance(value, (dict, list)) else ""
        return f"{path[0]} = {shown(value)}; allowed is {_phrase(node)}, the path of a file or folder.{guess}"
    if len(path) == 1 and path[0] != "scene":
        return f"{path[0]} = {shown(value)}; allowed is a table [[{path[0]}]] in double brackets, once for each"
    if path == ["scene"]:
        return f"scene = {shown(value)}; allowed is one table [scene] in single brackets"
    where, key = _where(path, document)
    if not key and not isinstance(value, dict):
        return f"{where} = {shown(value)}; allowed is a table of keys under [[{path[0]}]]"
    kinds = [kind.get("properties", {}).get("type", {}).get("const") for kind in node.get("oneOf", ())]
    if kinds and all(kinds):
        allowed = f"allowed is {_either([shown(kind) for kind in kinds])}"
        if kind == "union_tag_not_found":
            return f"{where}: type is missing; {allowed}"
        return f"{where}: type = {shown(value['type'])}; {allowed}{_guess(value['type'], kinds)}"
    if kind == "missing":
        meaning = f" ({node['description'].rstrip('.')})" if "description" in node else ""
        return f"{where}: {key} is missing; allowed is {_phrase(node)}{meaning}"
    return f"{where}: {key} = {shown(value)}; allowed is {_phrase(node)}{_advice(kind, value, node)}"


def _advice(kind: str, value, node: dict) -> str:
    if kind == "finite_number":
        return ". It must be finite"
    if "enum" in node:
        return _guess(value, node["enum"])
    if kind != "float_type":
        return ""
    if isinstance(value, bool):
        return ". true and false are no numbers here; write 1 or 0"
    if isinstance(value, int):
        return ", and a number that a float can hold"
    if isinstance(value, str) and value.replace(".", "", 1).removeprefix("-").isdigit():
        return f". Leave out the quotes: {value}"
    return ""


def _meant(path: list, known: Iterable[str]) -> tuple[str | None, str]:
    """The known key that an unknown one stands for, if any, and what is to be said about it."""
    likely, said = elsewhere(path[-1], known, path[0])
    return (likely, said) if likely or said else (_likely(path[-1], known), "")


def _unknown_key(path: list, value, likely: str | None, said: str, node: dict, document: dict) -> str:
    known = scene_schema()["properties"]
    alone = [key for key, node in known.items() if node.get("type") == "string"]
    tables = {key: f"[{key}]" if key == "scene" else f"[[{key}]]" for key in known if key not in alone}
    if len(path) == 1:
        guess = f" Did you mean {tables.get(likely, likely)}?" if likely else ""
        if not isinstance(value, (dict, list)):
            return f"{path[0]} = {shown(value)} is in no table.{guess} Allowed are {', '.join(tables.values())}"
        return f"unknown table [{path[0]}].{guess} Allowed are {', '.join(tables.values())}"
    guess = f" {said[0].upper()}{said[1:]}." if said else f" Did you mean {shown(likely)}?" if likely else ""
    if path[-1] in alone:
        guess = f" Write {path[-1]} above the first table of the file."
    where, key = _where(path, document)
    return f"{where}: unknown key {key} = {shown(value)}.{guess} Allowed are {', '.join(node['properties'])}"


def _guess(said, known: Iterable[str]) -> str:
    likely = _likely(said, known) if isinstance(said, str) else None
    return f". Did you mean {shown(likely)}?" if likely else ""


def _likely(key: str, known: Iterable[str]) -> str | None:
    """The known key that an unknown one stands for, if any."""
    plain = key.lower().replace("-", "_")
    meant, _ = elsewhere(key, known, "")
    return meant or next(iter(difflib.get_close_matches(plain, list(known), n=1, cutoff=0.5)), None)


def _where(path: list, document: dict) -> tuple[str, str]:
    """The place and the key, such as ('object "ball" (3rd [[object]])', 'vertices[2][0]')."""
    if isinstance(path[1], int):
        entry = document[path[0]][path[1]]
        where, rest = place(path[0], path[1], entry.get("name") if isinstance(entry, dict) else None), path[2:]
    else:
        where, rest = path[0], path[1:]
    return where, "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in rest).removeprefix(".")


def _phrase(node: dict, count: str = "") -> str:
    """What the schema allows, in words; with a count, in the plural."""
    if "oneOf" in node:
        return _either([_phrase(kind) for kind in node["oneOf"]])
    if "enum" in node or "const" in node:
        return _either([f'"{text}"' for text in node.get("enum", [node.get("const")])])
    if node["type"] in ("number", "integer"):
        noun = "number" if node["type"] == "number" else "whole number"
        return f"{count} {noun}s{_limits(node)}" if count else f"a {noun}{_limits(node)}"
    if node["type"] == "array":
        shortest, longest = node.get("minItems"), node.get("maxItems")
        items = _phrase(node["items"], f"{shortest}" if longest == shortest else f"{shortest} or more")
        return f"{count} lists of {items}" if count else f"a list of {items}"
    if node["type"] == "object":
        needed = node.get("required", node["properties"])
        inside = ", ".join([f"{key} = {_phrase(node['properties'][key])}" for key in needed])
        inside += ", ..." if len(needed) < len(node["properties"]) else ""
        return "{ " + inside + " }" if len(inside) < 120 else "a table of keys"
    if node["type"] == "boolean":
        return "true or false"
    return "text in quotes" + (", at least one letter" if node.get("minLength") else "")


def _limits(node: dict) -> str:
    signs = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}
    limits = [f"{sign} {node[key]:g}" for key, sign in signs.items() if key in node]
    return f" {' and '.join(limits)}" if limits else ""


def _either(parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} or {parts[-1]}"
