"""`diffwhitted fit --texture`: the texels of a texture from pictures, as pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ._folder import check_folder, saved_into
from ._progress import Progress, safe

if TYPE_CHECKING:
    from diffwhitted import Scene
    from fitting import Target, TextureFit


def refuse_beside_texture(**given: Any) -> None:
    """Refuse the options that speak of single numbers, or of what the fit of a texture does not do."""
    for name in (name for name, value in given.items() if value):
        option = f"--{name.replace('_', '-')}"
        raise typer.BadParameter(
            f"{option} does not go with --texture, which looks for all texels and for nothing else"
        )


def fit_map(
    scene: Scene,
    texture: str,
    targets: Sequence[Target],
    options: dict[str, Any],
    out: Path,
    source: str,
    json: bool,
    progress: Progress,
) -> int:
    """Fit, write the folder, and print how it ended; the exit code."""
    from fitting import fit_texture
    from fitting.telling._map_outputs import map_summary, write_map

    from ._targets import with_shots

    scene = with_shots(scene, targets, progress.note)
    check_folder(out)
    progress.say("compiling; less to do next time")
    result: TextureFit = fit_texture(
        scene,
        texture,
        targets,
        **options,
        on_step=lambda step, residual: progress.say(f"fitting: step {step + 1}, residual {residual:.4g}"),
    )
    progress.say("writing the maps")
    written = write_map(result, out, save_scene=saved_into(out), metadata={"scene": source})
    if json:
        print(written[0].read_text(encoding="utf-8"), end="")
    else:
        for line in (*map_summary(result), f"Texels: {written[1]}"):
            print(safe(line))
    return 0 if result.status == "converged" else 1
