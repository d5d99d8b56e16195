"""Traced programs kept in files beside JAX's compiled ones, so that a later process does not trace them again.

JAX's own cache saves the work of XLA; tracing and lowering remain, and take longer than many a picture. Here a program
is exported to a file when it is first traced (`jax.export`), and read back by the next process that asks for the same
one. Off until a folder is named, which only the command line does. A file that is broken or of another version is as
good as none: it is written anew, and nothing fails for it.
"""

import functools
import hashlib
import pickle
import re
import threading
import types
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import equinox as eqx
import jax
import jax.export
import numpy as np
from jax.core import Tracer

MOST_FILES = 500
"""The oldest are removed when there are more."""

_OURS = [jax.export.DisabledSafetyCheck.custom_call("lapack_sormqr_ffi")]
"""Calls that JAX may change between versions: a file is for one version."""
_FOLDER: list[Path] = []
_LOCK = threading.Lock()


def keep_programs(folder: Path | None) -> None:
    """Keep the programs of this process in a folder, which is there and can be written; None: in none, as at first."""
    _FOLDER[:] = [] if folder is None else [folder]


def kept(fun: Callable) -> Callable:
    """`eqx.filter_jit(fun)`, whose traced program is kept where `keep_programs` says.

    Arrays are arguments of the program, all else is static and a part of its key, by its `repr`; so
    the fields of static records must show there.
    """
    jitted, programs = eqx.filter_jit(fun), {}

    def find(args, kwargs):
        """The kept program, what its results are, and its arguments; None where there is none."""
        if not _FOLDER or any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves((args, kwargs))):
            return None
        arrays, static = eqx.partition((args, kwargs), _is_array)
        leaves, structure = jax.tree.flatten(arrays)
        shapes = tuple(jax.ShapeDtypeStruct(np.shape(a), a.dtype) for a in leaves)
        key = structure, shapes, tuple(jax.tree.leaves(static)), jax.tree.structure(static)
        with _LOCK:
            if key not in programs:
                programs[key] = _program(fun, structure, shapes, static)
        return programs[key] and (*programs[key], leaves)

    @functools.wraps(fun)
    def call(*args, **kwargs):
        if (found := find(args, kwargs)) is None:
            return jitted(*args, **kwargs)
        program, results, leaves = found
        return jax.tree.unflatten(results, program(*leaves))

    def lower(*args, **kwargs):
        """The program lowered, to be compiled ahead or looked at."""
        found = find(args, kwargs)
        return jitted.lower(*args, **kwargs) if found is None else found[0].lower(*found[2])  # pyright: ignore[reportAttributeAccessIssue]

    call.lower = lower  # pyright: ignore[reportAttributeAccessIssue]
    return call


def _is_array(leaf) -> bool:
    return isinstance(leaf, (jax.Array, np.ndarray, np.generic))


def _program(fun: Callable, structure, shapes, static):
    """The program for arguments of these shapes, from its file or traced and written there, and what its results are.

    None where it cannot be kept: something static is known by its place in memory, or JAX cannot export it.
    """
    name = f"{fun.__module__}.{fun.__qualname__}"
    platform, wide = jax.default_backend(), jax.dtypes.canonicalize_dtype(float).name
    others = [_written(leaf) for leaf in jax.tree.leaves(static)]
    key = _ordered(repr((_fingerprint(), name, platform, wide, structure, shapes, others, jax.tree.structure(static))))
    if " at 0x" in key:
        return None
    path = _FOLDER[0] / f"{fun.__name__.strip('_')}-{hashlib.sha256(key.encode()).hexdigest()[:40]}"
    found = _read(path)
    if found is None:
        results = []

        def flat(*leaves):
            args, kwargs = eqx.combine(jax.tree.unflatten(structure, leaves), static)
            out, tree = jax.tree.flatten(fun(*args, **kwargs))
            results.append(tree)
            return out

        flat.__name__ = fun.__name__
        try:
            exported = jax.export.export(jax.jit(flat), disabled_checks=_OURS)(*shapes)
        except (NotImplementedError, ValueError):
            return None
        found = exported, results[0]
        _write(path, exported, results[0])
    exported, tree = found

    def program(*leaves):
        return exported.call(*leaves)

    program.__name__ = fun.__name__
    return jax.jit(program), tree


def _ordered(text: str) -> str:
    """A `repr` with its sets in order: each process has its own order of strings."""
    return re.sub(r"\{([^{}:]*)\}", lambda found: "{" + ", ".join(sorted(found[1].split(", "))) + "}", text)


def _written(leaf) -> str:
    """What is static, as it is written in a key; a function by its name, where it has no variables of its own."""
    if isinstance(leaf, types.FunctionType) and not leaf.__closure__ and "<lambda>" not in leaf.__qualname__:
        return f"{leaf.__module__}.{leaf.__qualname__}"
    return repr(leaf)


def _read(path: Path):
    """The exported program of a file and the structure of its results; None where there is none that can be used."""
    try:
        content = path.read_bytes()
        digest, content = content[:32], content[32:]
        if hashlib.sha256(content).digest() != digest:
            return None
        program, numbered = pickle.loads(content)
        path.touch()
        return jax.export.deserialize(bytearray(program)), jax.tree.structure(numbered)
    except Exception:  # whatever is wrong with a file, the program is traced as if it were not there
        return None


def _write(path: Path, exported, results) -> None:
    """Write the file, under another name first; in silence where that cannot be done."""
    try:
        numbered = jax.tree.unflatten(results, range(results.num_leaves))
        content = pickle.dumps((bytes(exported.serialize()), numbered))
        beside = path.with_name(f".{path.name}-{threading.get_ident()}")
        beside.write_bytes(hashlib.sha256(content).digest() + content)
        beside.replace(path)
        files = sorted(path.parent.iterdir(), key=lambda file: file.stat().st_mtime)
        for old in files[:-MOST_FILES]:
            old.unlink(missing_ok=True)
    except (OSError, pickle.PicklingError, ValueError, TypeError, NotImplementedError):
        return


@functools.cache
def _fingerprint() -> str:
    """Of all that a traced program depends on beside its arguments: our source, and the libraries that trace it."""
    digest = hashlib.sha256()
    for name in ("jax", "jaxlib", "equinox", "optimistix", "lineax", "numpy"):
        digest.update(f"{name} {version(name)} ".encode())
    here = Path(__file__).parents[2]
    for package in ("diffwhitted", "fitting"):
        for source in sorted((here / package).rglob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()
