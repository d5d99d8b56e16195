"""What several commands have in common: their options, and how a scene and a camera are chosen by them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

if TYPE_CHECKING:
    from diffwhitted import Scene
    from diffwhitted.scene import AbstractCamera


class Precision(StrEnum):
    """The floating-point type of a whole computation."""

    float32 = "float32"
    float64 = "float64"


ScenePath = Annotated[
    Path,
    typer.Argument(
        metavar="SCENE",
        help="Scene file: TOML, or .pov, .xml, .gltf, .yml, .nff, ... of other programs.",
        show_default=False,
    ),
]
CameraName = Annotated[
    str | None,
    typer.Option(
        "--camera", metavar="NAME", help='Camera of the scene. Default: "main", or the only one.', show_default=False
    ),
]
Width = Annotated[
    int | None,
    typer.Option(
        "--width",
        metavar="PIXELS",
        min=1,
        max=32768,
        show_default=False,
        help="Columns of the picture. Default: the camera's; with --height alone its shape is kept.",
    ),
]
Height = Annotated[
    int | None,
    typer.Option(
        "--height",
        metavar="PIXELS",
        min=1,
        max=32768,
        show_default=False,
        help="Rows of the picture. Default: the camera's; with --width alone its shape is kept.",
    ),
]
Depth = Annotated[
    int | None,
    typer.Option(
        "--depth",
        metavar="LEVELS",
        min=1,
        max=64,
        show_default=False,
        help="Longest path from the camera: 1 is camera rays only. Default: max_depth of the scene.",
    ),
]
Samples = Annotated[
    int, typer.Option("--samples", metavar="N", min=1, max=64, help="N x N rays a pixel, on a regular grid.")
]
Footprint = Annotated[
    int | None,
    typer.Option(
        "--footprint",
        metavar="K",
        min=0,
        max=64,
        show_default=False,
        help="K x K trees a pixel whose rays average what they meet over their share of it, edges and all; 0: points.",
    ),
]
Antialias = Annotated[
    float | None,
    typer.Option(
        "--antialias",
        metavar="T",
        show_default=False,
        help="Adaptive antialiasing: divide a pixel, to 1/8, where its corners differ by more than T of linear "
        "light, such as 0.1.",
    ),
]
Cutoff = Annotated[
    float | None,
    typer.Option(
        "--cutoff",
        metavar="SHARE",
        min=0,
        max=1,
        show_default=False,
        help="Do not follow a branch that would carry less than this share of light. Default: cutoff of the "
        "scene, or 0: follow all.",
    ),
]
Tolerance = Annotated[
    str | None,
    typer.Option(
        "--tolerance",
        metavar="ERROR",
        show_default=False,
        help="Find the cheapest of these settings whose RMSE in linear RGB is no larger: a number or a fraction, "
        "such as 1/255.",
    ),
]
TimeBudget = Annotated[
    float | None,
    typer.Option(
        "--time-budget",
        metavar="SECONDS",
        show_default=False,
        help="Find the most accurate of these settings that takes no longer, once compiled.",
    ),
]
PrecisionName = Annotated[
    Precision,
    typer.Option("--precision", metavar="TYPE", help="float32, or float64: slower, for derivatives to the last digit."),
]

Only = Annotated[
    list[str] | None,
    typer.Option(
        "--only",
        metavar="OBJECT",
        show_default=False,
        help="Use only pixels that see this object first, and whose neighbours do; several may be named.",
    ),
]
HoldOut = Annotated[
    list[str] | None,
    typer.Option(
        "--hold-out",
        metavar="SHOT|SHARE",
        show_default=False,
        help="Leave a shot, or a share of the pixels such as 20%, out of the fit, and say how well they are predicted.",
    ),
]


class SeveralValues(TyperCommand):
    """A command whose repeatable options also take several values at once: `--free a.k_d b.k_d`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        return super().parse_args(ctx, spread(self.params, args))


def spread(parameters: Sequence[Any], arguments: list[str]) -> list[str]:
    """The arguments with `--free a b` written out as `--free a --free b`.

    The scene is the first argument that belongs to no option; what follows it and a repeatable option's
    value is a further value of that option.
    """
    options = {name: p for p in parameters if p.param_type_name == "option" for name in (*p.opts, *p.secondary_opts)}
    written, repeatable, scene_seen, queue = [], None, False, list(arguments)
    while queue:
        argument = queue.pop(0)
        if argument == "--":
            return [*written, argument, *queue]
        if argument.startswith("-") and argument != "-":
            option = options.get(argument.partition("=")[0])
            repeatable = argument.partition("=")[0] if option is not None and option.multiple else None
            written.append(argument)
            if option is not None and not option.is_flag and "=" not in argument and queue:
                written.append(queue.pop(0))
        elif repeatable and scene_seen:
            written += [repeatable, argument]
        else:
            scene_seen = True
            written.append(argument)
    return written


def chosen_camera(scene: Scene, name: str | None) -> tuple[str, AbstractCamera]:
    """The camera of that name; without a name "main", or the only one. Raises `InputError` for any other."""
    from diffwhitted import InputError
    from diffwhitted.scene import nearest_name

    known = list(scene.cameras)
    if not known:
        raise InputError("the scene has no camera; add a [[camera]]")
    if name is None:
        if "main" not in known and len(known) > 1:
            raise InputError(
                f"the scene has several cameras and none is called main; choose with --camera: {', '.join(known)}"
            )
        name = "main" if "main" in known else known[0]
    if name not in known:
        raise InputError(
            f"--camera {name}: there is no such camera; there is {', '.join(known)}.{nearest_name(name, known)}"
        )
    return name, scene.cameras[name]


def with_camera(scene: Scene, name: str, camera: AbstractCamera) -> Scene:
    """The scene with another camera of that name."""
    import equinox as eqx

    return eqx.tree_at(lambda s: s.cameras[name], scene, camera)
