"""JAX as the command line runs it: compiled programs are kept between runs, and nothing is said on stderr."""

import logging
import os
import warnings
from pathlib import Path
from types import ModuleType


def set_up(precision: str = "float32") -> None:
    """To be called once, before a scene is read. `JAX_PLATFORMS` and JAX's own cache settings are the user's.

    The cache of compiled programs is the user's cache folder (`XDG_CACHE_HOME` or ~/.cache on Linux); where that
    cannot be written, programs are compiled anew in silence. Raises `InputError` where JAX finds no such platform.
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
    if given is None and (folder := _cache_folder()) is not None:
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
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


def _cache_folder() -> Path | None:
    """A folder for compiled programs that can be written, made if need be."""
    from platformdirs import user_cache_path

    try:
        folder = user_cache_path("diffwhitted", appauthor=False) / "compiled"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) else None
