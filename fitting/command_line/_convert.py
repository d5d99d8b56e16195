"""`diffwhitted convert`: scenes and results of fits as other programs, papers and people read them."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ._environment import set_up
from ._progress import say

if TYPE_CHECKING:
    from diffwhitted.formats import SceneFormat

Source = Annotated[
    Path,
    typer.Argument(metavar="SCENE", show_default=False, help="Scene file, or a fit: its folder or its result.json."),
]
Target = Annotated[
    Path,
    typer.Argument(
        metavar="OUT",
        show_default=False,
        help="File to write: .pov (POV-Ray), .xml (Mitsuba 3), .gltf, .mtl, .json, .tex, .md, .toml.",
    ),
]
Form = Annotated[
    str | None,
    typer.Option(
        "--format",
        metavar="NAME",
        show_default=False,
        help="povray, mitsuba, gltf, mtl, json, latex, markdown or toml, where the suffix of OUT says something else.",
    ),
]
FITTED, RESULT = "fitted.toml", "result.json"


def convert(source: Source, out: Target, form: Form = None) -> None:
    """Write a scene, or what a fit has found, as another program reads it.

    \b
    The whole scene for POV-Ray, a fitted scene for Blender, the numbers of the fit for a paper:
      diffwhitted convert scene.toml scene.pov
      diffwhitted convert result fitted.gltf
      diffwhitted convert result table.tex

    Of a fit, .tex and .md are tables of what was fitted, with standard errors and 95 % intervals; all other formats
    get the fitted scene. What a format cannot say is said in notes, and in the file itself.
    """
    set_up()
    from diffwhitted import InputError, load_scene, save_scene
    from diffwhitted.formats import write_file
    from fitting.telling._fit_tables import TABLES, fit_table, read_result

    chosen = chosen_format(out, form)
    scene, result = found(source)
    used = [path for path in (source, scene, result) if path is not None]
    if any(same(path, out) for path in used):
        raise InputError(f"{out}: this is what is to be converted, and would be lost; give another name")
    if result is not None and chosen.name in TABLES:
        text, lost = fit_table(read_result(result), chosen.name)
        write_file(Path(os.path.realpath(out)), text.encode(), str(out))
    elif scene is None:
        raise InputError(f"{source}: {FITTED} is not beside it, so there is no scene to convert; give .tex or .md")
    else:
        lost = save_scene(load_scene(scene), out, form=chosen)
    for sentence in lost:
        say(f"note: {sentence}", file=sys.stderr)
    say(f"wrote {out}" + (f" ({chosen.name})" if form else ""))


def chosen_format(out: Path, name: str | None) -> SceneFormat:
    """The format by its name, or by the suffix of the file. Raises `InputError` for any other."""
    from diffwhitted import InputError
    from diffwhitted.formats import FORMATS
    from diffwhitted.scene import nearest_name

    written = [one for one in FORMATS if one.write is not None]
    if name is not None:
        by_name = {word: one for one in written for word in (_word(one.name), *(s[1:] for s in one.suffixes))}
        if _word(name) not in by_name:
            there = ", ".join(_word(one.name) for one in written)
            raise InputError(
                f"--format {name}: there is no such format; there is {there}.{nearest_name(name, by_name)}"
            )
        return by_name[_word(name)]
    for one in written:
        if out.suffix.lower() in one.suffixes:
            return one
    known = ", ".join(f"{suffix} ({one.name})" for one in written for suffix in one.suffixes)
    what = f"the suffix {out.suffix!r} is no format" if out.suffix else "without a suffix the format is not known"
    raise InputError(f"{out}: {what}; there is {known}, or say one with --format")


def _word(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())


def found(source: Path) -> tuple[Path | None, Path | None]:
    """The scene and the result that are meant: of a fit both, of a scene file the first."""
    from diffwhitted import InputError

    if source.is_dir():
        if not (source / RESULT).exists():
            raise InputError(f"{source}: there is no {RESULT} in this folder; give a scene file or the folder of a fit")
        source = source / RESULT
    if source.suffix.lower() != ".json":
        return source, None
    fitted = source.with_name(FITTED)
    return (fitted if fitted.exists() else None), source


def same(one: Path, other: Path) -> bool:
    """Are both the same file, by whatever way?"""
    return one.exists() and other.exists() and os.path.samefile(one, other)
