"""`diffwhitted scene`: scenes that many have rendered, as files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from ._environment import set_up
from ._progress import say

Name = Annotated[
    str | None, typer.Argument(metavar="NAME", show_default=False, help="Which scene; --list says what there is.")
]
Out = Annotated[
    Path | None,
    typer.Option("-o", "--out", metavar="FILE", show_default=False, help="File to write. Default: NAME.toml."),
]
Size = Annotated[
    int | None,
    typer.Option("--size", metavar="N", show_default=False, help="How much there is of it. Default: its usual size."),
]
Listed = Annotated[bool, typer.Option("--list", help="Say what scenes there are, with their sizes, and stop.")]


def scene(name: Name = None, out: Out = None, size: Size = None, listed: Listed = False) -> None:
    """Write a scene that many have rendered: Haines' databases, Whitted's figure 7, the Cornell box, glass on a table.

    \b
    The sphere flake, a smaller one, and what else there is:
      diffwhitted scene balls
      diffwhitted scene balls --size 2 -o few.toml
      diffwhitted scene --list

    Many spheres and triangles are written to files beside it (.npz, .ply), which the scene file names. Haines' scenes
    have z up.
    """
    from diffwhitted.standard import STANDARD

    if listed:
        longest = max(map(len, STANDARD))
        for known, entry in STANDARD.items():
            print(f"{known:{longest}}  N = {entry.size:<4} {entry.about}")
        return
    from diffwhitted import InputError, save_scene, standard_scene
    from diffwhitted.formats import with_files, write_file

    if name is None:
        raise InputError(f"the NAME of a scene is missing; there is {', '.join(STANDARD)}")
    out = Path(f"{name}.toml") if out is None else out
    if out.suffix.lower() != ".toml":
        raise InputError(f"{out}: scenes are written as TOML; end it with .toml, and use convert for other formats")
    set_up()
    made, files = with_files(standard_scene(name, size), out)
    for place, data in files.items():
        write_file(Path(os.path.realpath(place)), data, str(place))
    save_scene(made, out)
    beside = f", and beside it {', '.join(place.name for place in files)}" if len(files) < 5 else (
        f", and {len(files)} files beside it"
    )  # fmt: skip
    say(f"wrote {out}{beside if files else ''}: {len(made.objects):,} objects of "
        f"{sum(thing.surfaces for thing in made.objects):,} surfaces")  # fmt: skip
