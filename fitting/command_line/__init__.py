"""The command line: `diffwhitted render`, `animate`, `fit`, `derivative`, `explain`, `tradeoff`, `identify`,
`parameters`, `convert`, `scene` and `schema`.

A command's file imports what it needs when it runs, so that `--help` does not wait for JAX. Every failure is
one message on stderr and an exit code; there is never a traceback.
"""

import sys
import warnings
from collections.abc import Sequence
from functools import partial
from typing import Annotated, Any

import typer

from ._animate import animate
from ._convert import convert
from ._derivative import derivative
from ._explain import explain
from ._failures import failed
from ._fit import fit
from ._identify import identify
from ._options import SeveralValues
from ._parameters import parameters
from ._progress import say
from ._render import render
from ._scene import scene
from ._schema import schema
from ._tradeoff import tradeoff

USAGE_ERROR: Any = typer.BadParameter.__base__
STOPPED = 130
"""The exit code of a program that Ctrl-C has ended, as shells know it."""

app = typer.Typer(
    name="diffwhitted",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Start with: diffwhitted render SCENE.toml -o picture.png. COMMAND --help explains every option.",
)
app.command(cls=SeveralValues, short_help="Render a scene to an image file.")(render)
app.command(cls=SeveralValues, short_help="Write a film of a scene whose numbers change.")(animate)
app.command(cls=SeveralValues, short_help="Find material coefficients, and other numbers, from pictures.")(fit)
app.command(cls=SeveralValues, short_help="Say what a fit would know, before a picture is taken.")(identify)
app.command(cls=SeveralValues, short_help="Show how a picture changes with a number of the scene.")(derivative)
app.command(cls=SeveralValues, short_help="Say what a picture costs, and why.")(explain)
app.command(cls=SeveralValues, short_help="Measure what accuracy costs in time.")(tradeoff)
app.command(short_help="List the numbers of a scene by name.")(parameters)
app.command(short_help="Write a scene or a fit as other programs read it.")(convert)
app.command(short_help="Write a scene that many have rendered.")(scene)
app.command(short_help="Print the JSON Schema of scene files.")(schema)


@app.callback(invoke_without_command=True)
def diffwhitted(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """A differentiable Whitted ray tracer that finds materials from pictures.

    Scenes are TOML files, or those of other programs (POV-Ray, Mitsuba, glTF, NFF); pictures are OpenEXR, Radiance,
    TIFF, PNG or JPEG. Exit codes: 0 done, 1 a fit that has not converged or is not determined, 2 something given
    cannot be used.
    """
    if version:
        print(version_line())
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


def version_line() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"diffwhitted {version('diffwhitted')}"
    except PackageNotFoundError:
        return "diffwhitted, run from its source"


def _noted(otherwise, message, category, *where, **how) -> None:
    """Show a warning of ours as a note, and any other as Python does."""
    if category.__module__.partition(".")[0] in ("diffwhitted", "fitting"):
        say(f"note: {message}", file=sys.stderr)
    else:
        otherwise(message, category, *where, **how)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line (`sys.argv[1:]` by default) and return its exit code."""
    try:
        with warnings.catch_warnings():
            warnings.showwarning = partial(_noted, warnings.showwarning)
            code = app(None if arguments is None else list(arguments), prog_name="diffwhitted", standalone_mode=False)
        sys.stdout.flush()
    except USAGE_ERROR as error:
        command = error.ctx.command_path if error.ctx else "diffwhitted"
        say(f"error: {error.format_message().rstrip('.')}. See {command} --help", file=sys.stderr)
        return 2
    except typer.Abort:
        code = STOPPED
    except BrokenPipeError:
        sys.stdout = None
        return 1
    except Exception as error:
        # A compiled module that is being imported turns a Ctrl-C into an ImportError.
        if not isinstance(error.__cause__ or error.__context__, KeyboardInterrupt):
            return failed(error)
        code = STOPPED
    if code == STOPPED:
        print("stopped", file=sys.stderr)
    return code or 0
