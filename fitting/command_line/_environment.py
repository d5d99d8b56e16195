"""JAX as the command line runs it: compiled programs are kept between runs, and nothing is said on stderr."""

import logging
import os
import re
import sys
import warnings
from pathlib import Path
from types import ModuleType


def set_up(precision: str = "float32") -> None:
    """To be called once, before a scene is read. `JAX_PLATFORMS` and JAX's own cache settings are the user's.

    Programs are kept in the user's cache folder (`XDG_CACHE_HOME` or ~/.cache on Linux), as they are traced and as they
    are compiled; where that cannot be written, they are made anew in silence. Raises `InputError` where JAX finds no
    such platform.
    """
    # Read by JAX's C++ half when it is loaded: 3 leaves fatal errors only.
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    import jax

    for talker in ("jax", "absl", "matplotlib"):
        logging.getLogger(talker).setLevel(logging.ERROR)
    warnings.filterwarnings("ignore", message=".*compilation cache.*")
    if precision == "float64":
        jax.config.update("jax_enable_x64", True)
    given = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    if given is None and (folder := _cache_folder("compiled")) is not None:
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
        forget_broken_programs(folder)
    if (folder := _cache_folder("traced")) is not None:
        from diffwhitted.numerics._kept import keep_programs

        keep_programs(folder)
    platforms = jax.config.jax_platforms  # pyright: ignore[reportAttributeAccessIssue]
    if platforms:
        _check_platforms(jax, platforms)


def _check_platforms(jax: ModuleType, platforms: str) -> None:
    from diffwhitted import InputError

    try:
        jax.devices()
    except (RuntimeError, AssertionError) as error:
        raise InputError(
            f"JAX cannot compute on JAX_PLATFORMS = {platforms!r}: "
            f"{' '.join(str(error).split())[:200] or 'not found'}; "
            "unset it, or set it to cpu"
        ) from None


def forget_broken_programs(folder: Path) -> None:
    """When JAX finds a program in its cache that it cannot read, remove it, so that it is written anew; say so once.

    JAX compiles such a program anew at each start, and never writes over its file. It says no more than the program's
    name, in a warning; so all files of that name are removed.
    """
    said, show = [], warnings.showwarning

    def remove(message, *details, **more):
        found = re.match(r"Error reading persistent compilation cache entry for '(\w+)'", str(message))
        if found is None:
            return show(message, *details, **more)
        for path in folder.glob(f"{found[1]}-*"):
            path.unlink(missing_ok=True)
        if not said:
            said.append(True)
            print(f"note: broken files in the cache of compiled programs, {folder}, are written anew", file=sys.stderr)

    warnings.filterwarnings("always", message="Error reading persistent compilation cache entry.*")
    warnings.showwarning = remove


def _cache_folder(name: str) -> Path | None:
    """A folder for programs of a kind that can be written, made if need be."""
    from platformdirs import user_cache_path

    try:
        folder = user_cache_path("diffwhitted", appauthor=False) / name
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) else None
