"""Set-up of the whole test process, before the packages are imported.

64-bit JAX, so that formulas are tested where rounding does not hide them; scenes stay in float32 unless a test asks for
float64. Compiled programs are kept between runs in `.cache/` and shared by the workers, the notebooks' kernels and the
command line's processes (`JAX_COMPILATION_CACHE_DIR` names another folder). Annotations are checked while the tests
run, unless `CHECK_ANNOTATIONS=0`.
"""

import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
KEPT = {
    "JAX_COMPILATION_CACHE_DIR": str(ROOT / ".cache" / "compiled"),
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
}
for _name, _value in KEPT.items():
    os.environ.setdefault(_name, _value)

import equinox as eqx  # noqa: E402 JAX reads its environment when it is imported
import jax  # noqa: E402
import pytest  # noqa: E402
from annotations import PACKAGES  # noqa: E402
from jaxtyping import install_import_hook  # noqa: E402

if os.environ.get("CHECK_ANNOTATIONS") == "1" or "HOOK" in os.environ:
    install_import_hook(list(PACKAGES), os.environ.get("HOOK", "annotations.checked"))

jax.config.update("jax_enable_x64", True)

SOON_COMPILED = {"xla_backend_optimization_level": 0}
"""For programs that are compiled for longer than they run: the same operations, without optimisation of the machine
code.
"""

SLOW = (
    "test_notebooks",
    "test_edges",
    "test_fit_index",
    "test_gradients",
    "test_fuzz",
    "test_fit",
    "test_edges_of_shapes",
    "test_effects",
    "test_tradeoff",
    "test_tradeoff_command",
    "test_tradeoff_fit",
    "test_cutoff",
    "test_fit_end",
    "test_cost",
    "test_derivative",
    "test_stages",
    "test_hard_cases",
    "test_film",
    "test_shapes",
    "test_shape_records",
    "test_shape_pictures",
    "test_lamps",
    "test_lossy",
    "test_fit_texture",
    "test_image_textures",
    "test_search",
    "test_meshes",
    "test_standard",
    "test_filters",
    "test_parameters",
    "test_real_pictures",
    "test_codes",
    "test_mesh_outlines",
    "test_mesh_shading",
    "test_lens",
    "test_motion",
    "test_wrinkles",
    "test_radiosity",
)
"""Files that compile for long: `make quick` leaves them out. The longest are begun first, so that no worker is left
with one at the end.
"""


def pytest_collection_modifyitems(items):
    def place(item):
        return SLOW.index(item.path.stem) if item.path.stem in SLOW else len(SLOW)

    for item in items:
        if item.path.stem != "test_notes":
            # Scenes of tests are odd on purpose.
            item.add_marker(pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote"), append=False)
        if item.path.stem in SLOW:
            item.add_marker(pytest.mark.slow)
    items.sort(key=place)


@pytest.fixture(autouse=True, scope="module")
def _few_programs():
    """Let go of the compiled programs at the end of a file when there are many, or when they fill the memory.

    Each of them maps memory some dozens of times, and a process may do so 65530 times on Linux: past that XLA crashes.
    """
    yield
    maps, pages = Path("/proc/self/maps"), Path("/proc/self/statm")
    many = maps.exists() and maps.read_bytes().count(b"\n") > 25_000
    if many or (pages.exists() and int(pages.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") > 3 * 2**30):
        eqx.clear_caches()
        jax.clear_caches()


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a scene, a start that is off, and a target, which is the current folder."""
    from command_line_samples import SCENE, rendered

    from diffwhitted import write_image

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "start.toml").write_text(SCENE.replace("k_d = 0.5", "k_d = 0.2").replace("= 20", "= 60"))
    write_image("target.exr", rendered("scene.toml"))
    return tmp_path
