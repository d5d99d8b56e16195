"""Traced programs in files: read back by another process, written anew where they are broken, and never in the way."""

import os
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from diffwhitted.numerics._kept import keep_programs, kept

TRACED = []


def scaled(tree, power: int):
    TRACED.append(power)
    return {"sum": jnp.sum(tree["a"] ** power), "same": tree["b"]}


@pytest.fixture
def folder(tmp_path):
    keep_programs(tmp_path)
    TRACED.clear()
    yield tmp_path
    keep_programs(None)


TREE = {"a": np.arange(3.0), "b": np.array([1, 2])}


def test_a_program_is_traced_once_and_read_back(folder):
    for _fresh in range(2):  # a new wrapper stands for a new process: it knows no program yet
        program = kept(scaled)
        for factor in (1.0, 2.0):
            found = program({"a": factor * TREE["a"], "b": TREE["b"]}, 2)
            assert float(found["sum"]) == 5 * factor**2
            np.testing.assert_array_equal(found["same"], [1, 2])
        assert TRACED == [2] and len(list(folder.iterdir())) == 1


def test_what_is_static_and_the_shapes_are_in_the_key(folder):
    for power, size in ((2, 3), (3, 3), (2, 4)):
        found = kept(scaled)({"a": np.arange(float(size)), "b": TREE["b"]}, power)
        assert float(found["sum"]) == sum(n**power for n in range(size))
    assert len(list(folder.iterdir())) == len(TRACED) == 3


@pytest.mark.parametrize("damage", [lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b[:-1] + bytes([b[-1] ^ 1])])
def test_a_broken_file_is_written_anew(folder, damage):
    kept(scaled)(TREE, 2)
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert float(kept(scaled)(TREE, 2)["sum"]) == 5
    assert TRACED == [2, 2] and len(path.read_bytes()) == len(whole)
    kept(scaled)(TREE, 2)
    assert TRACED == [2, 2]


def test_a_folder_that_is_gone_is_no_error(folder):
    keep_programs(folder / "nowhere")
    assert float(kept(scaled)(TREE, 2)["sum"]) == 5


def test_traced_arguments_and_functions_without_a_name_are_not_kept(folder):
    assert float(jax.grad(lambda a: kept(scaled)({"a": a, "b": TREE["b"]}, 2)["sum"])(TREE["a"])[1]) == 2

    def call(function, x):
        return function(x)

    for n in (1.0, 2.0):
        assert float(kept(call)(lambda x, n=n: n * x, jnp.asarray(3.0))) == 3 * n
    assert not list(folder.iterdir())


def test_another_process_finds_the_program(tmp_path):
    """Also where a set is static: each process has its own order of strings."""
    script = (
        "import sys, jax.numpy as jnp\n"
        "from pathlib import Path\n"
        "from diffwhitted.numerics._kept import keep_programs, kept\n"
        "def named(names, x):\n"
        "    return len(names) * x\n"
        "keep_programs(Path(sys.argv[1]))\n"
        "print(kept(named)(frozenset('abcdefgh'), jnp.asarray(2.0)))\n"
    )
    for seed in ("1", "2"):
        command = [sys.executable, "-c", script, str(tmp_path)]
        done = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"PYTHONHASHSEED": seed})
        assert done.stdout.strip() == "16.0", done.stderr
    assert len(list(tmp_path.iterdir())) == 1


def test_broken_compiled_programs_are_found_and_forgotten(tmp_path):
    """A truncated file of JAX's cache: JAX itself compiles anew each time and never writes over it."""
    script = (
        "import sys, warnings, jax, jax.numpy as jnp\n"
        "from pathlib import Path\n"
        "from fitting.command_line._environment import forget_broken_programs\n"
        "jax.config.update('jax_compilation_cache_dir', sys.argv[1])\n"
        "jax.config.update('jax_persistent_cache_min_compile_time_secs', 0)\n"
        "jax.config.update('jax_persistent_cache_min_entry_size_bytes', -1)\n"
        "forget_broken_programs(Path(sys.argv[1]))\n"
        "print(jax.jit(lambda x: jnp.sin(x) @ x)(jnp.ones(5)))\n"
    )
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_COMPILATION", "JAX_PERSISTENT"))}

    def run():
        command = [sys.executable, "-c", script, str(tmp_path)]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120)
        assert done.returncode == 0, done.stderr
        return done

    def programs() -> dict[str, int]:
        return {path.name: path.stat().st_size for path in tmp_path.iterdir() if path.name.endswith("-cache")}

    first = run()
    whole = programs()
    assert whole and not first.stderr
    for name in whole:
        Path(tmp_path / name).write_bytes((tmp_path / name).read_bytes()[:100])
    second = run()
    assert second.stdout == first.stdout and programs() == whole
    assert second.stderr.count("\n") == 1 and "broken" in second.stderr
    assert run().stderr == ""
