"""What the documentation says of lists that the program holds: keys of a scene file, coefficients, knobs, options.

Writes a Markdown file for each into `.cache/docs/`, from where the pages include them. `make docs` runs it.
"""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import typer

import diffwhitted
from fitting.command_line import app

FOLDER = Path(".cache/docs")
WIDTH = 96
"""Columns of a command's help."""


def command_line() -> str:
    """Each command's own help."""
    group: Any = typer.main.get_command(app)
    parts = [_help(group, "diffwhitted", None)]
    context = group.make_context("diffwhitted", ["schema"])
    for name, command in group.commands.items():
        parts += [f"## {name}", _help(command, name, context)]
    return "\n\n".join(parts)


def _help(command: Any, name: str, parent: Any) -> str:
    context = command.context_class(
        command, info_name=name, parent=parent, terminal_width=WIDTH, max_content_width=WIDTH
    )
    return f"```text\n{command.get_help(context).strip()}\n```"


def coefficients() -> str:
    """The table of material coefficients."""
    rows = (
        (
            f"`{row.name}`",
            row.meaning,
            f"{row.lowest:g} to {row.highest:g}".replace("inf", "∞"),
            "that of k_s" if row.default is None else f"{row.default:g}",
            "{:g} to {:g}".format(*row.fit_bounds or ()),
            "yes" if row.coloured else "no",
            row.source,
        )
        for row in diffwhitted.COEFFICIENTS
    )
    return _table(("name", "meaning", "allowed", "default", "a fit looks in", "may be linear RGB", "source"), rows)


def knobs() -> str:
    """The table of what trades accuracy for time."""
    rows = ((f"`{knob.name}`", str(knob.default), knob.controls, knob.costs) for knob in diffwhitted.KNOBS)
    return _table(("knob", "default", "the error that it makes smaller", "what it costs"), rows)


def scene_keys() -> str:
    """Each table of a scene file with its keys, from the JSON Schema."""
    schema = diffwhitted.scene_schema()
    definitions, parts, listed = schema["$defs"], [], set()
    alone = {name: key for name, key in schema["properties"].items() if key.get("type") == "string"}
    parts += ["## Above the first table", _keys({"properties": alone}, definitions)]
    for name, table in schema["properties"].items():
        if name in alone:
            continue
        parts += [f"## {'[[' if 'items' in table else '['}{name}{']]' if 'items' in table else ']'}"]
        items = table.get("items", table)
        listed |= {_reference(kind) for kind in items.get("oneOf", [items])}
        kinds = [definitions[_reference(kind)] for kind in items.get("oneOf", [items])]
        for kind in kinds:
            parts += [f"### {kind['title']}"] if len(kinds) > 1 else []
            parts += [kind["description"], _keys(kind, definitions)]
    found = dict.fromkeys(re.findall(r"#/\$defs/(\w+)", str(schema)))
    inline = [definitions[name] for name in found if name not in listed]
    for kind in inline:
        parts += [f"## `{{ {', '.join(kind['properties'])} }}`", kind["description"], _keys(kind, definitions)]
    return "\n\n".join(parts)


def _reference(kind: Mapping[str, Any]) -> str:
    return kind["$ref"].rpartition("/")[2]


def _keys(entry: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    required = entry.get("required", ())
    rows = (
        (
            f"`{key}`",
            _kind(field, definitions),
            "needed" if key in required else f"`{field['default']}`" if "default" in field else "none",
            field.get("description", "which of its kind this is"),
        )
        for key, field in entry["properties"].items()
    )
    return _table(("key", "value", "default", "meaning"), rows)


def _kind(field: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    """What a key takes, in a few words."""
    if "$ref" in field:
        return f"`{{ {', '.join(definitions[_reference(field)]['properties'])} }}`"
    if "const" in field:
        return f"`{field['const']}`"
    if "enum" in field:
        return " or ".join(f"`{value}`" for value in field["enum"])
    if choices := field.get("anyOf") or field.get("oneOf"):
        return " or ".join(dict.fromkeys(_kind(choice, definitions) for choice in choices))
    if field.get("type") == "array":
        least, most = field.get("minItems"), field.get("maxItems")
        count = f"{least} " if least == most and least is not None else f"{least or 0} or more "
        return f"list of {count}({_kind(field['items'], definitions)})"
    return {"string": "text", "integer": "whole number"}.get(field.get("type", ""), str(field.get("type", "value")))


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    def line(cells: Iterable[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"

    head = tuple(head)
    return "\n".join([line(head), line("---" for _ in head), *map(line, rows)])


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for page in (coefficients, command_line, knobs, scene_keys):
        (FOLDER / f"{page.__name__}.md").write_text(page() + "\n", encoding="utf-8")
