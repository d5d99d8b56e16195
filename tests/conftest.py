"""Set-up of the whole test process: 64-bit JAX, so that formulas are tested where rounding does not hide them.

Scenes stay in float32 unless a test asks for float64.
"""

from pathlib import Path

import equinox as eqx
import jax
import pytest

jax.config.update("jax_enable_x64", True)

SOON_COMPILED = {"xla_backend_optimization_level": 0}
"""For programs that are compiled for longer than they run: the same operations, without optimisation of the machine
code.
"""

LONGEST = ("test_notebooks", "test_edges", "test_fit_index", "test_gradients", "test_fuzz", "test_fit")
"""Files that take minutes, begun first so that no worker is left with one at the end."""


def pytest_collection_modifyitems(items):
    def place(item):
        name = item.path.stem
        return LONGEST.index(name) if name in LONGEST else len(LONGEST)

    items.sort(key=place)


@pytest.fixture(autouse=True, scope="module")
def _few_programs():
    """Let go of the compiled programs at the end of a file when there are many.

    Each of them maps memory some dozens of times, and a process may do so 65530 times on Linux: past that XLA crashes.
    """
    yield
    maps = Path("/proc/self/maps")
    if maps.exists() and maps.read_bytes().count(b"\n") > 25_000:
        eqx.clear_caches()
        jax.clear_caches()
