"""The house: imports point one way, public names are documented ones, files stay small, importing is cheap."""

import ast
import inspect
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LONGEST = 300
"""Lines of a file."""

LAYERS = (
    "diffwhitted._errors",
    "diffwhitted._files",
    "diffwhitted._lazily",
    "diffwhitted.numerics",
    "diffwhitted.geometry",
    "diffwhitted.records",
    "diffwhitted.shapes",
    "diffwhitted.scene",
    "diffwhitted.optics",
    "diffwhitted.illumination",
    "diffwhitted.tree",
    "diffwhitted.image",
    "diffwhitted.rendering",
    "diffwhitted.cost",
    "diffwhitted.accuracy",
    "diffwhitted._render",
    "diffwhitted.formats",
    "diffwhitted",
    "fitting._errors",
    "fitting._result",
    "fitting.problem",
    "fitting.judging",
    "fitting.solving",
    "fitting._outcome",
    "fitting._fit",
    "fitting.telling",
    "fitting.comparing",
    "fitting",
    "fitting.command_line",
    "fitting.__main__",
)
"""Rooms from the ground up. A file imports from its own room and from those below, also within functions."""


def files() -> list[Path]:
    return sorted(path for package in ("diffwhitted", "fitting") for path in (ROOT / package).rglob("*.py"))


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def room_of(module: str) -> str:
    """The room with the longest name that holds the module."""
    rooms = [room for room in LAYERS if module == room or module.startswith(f"{room}.")]
    return max(rooms, key=len)


def imports(path: Path) -> Iterator[str]:
    """Modules of the two packages that a file imports, wherever in it."""
    package = module_of(path) if path.stem == "__init__" else module_of(path).rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            source = ".".join([*above, *([node.module] if node.module else [])])
            # What is imported may be a module itself.
            found = [name if is_module(name := f"{source}.{alias.name}") else source for alias in node.names]
        else:
            continue
        yield from (name for name in found if name.split(".")[0] in ("diffwhitted", "fitting"))


def is_module(name: str) -> bool:
    path = ROOT.joinpath(*name.split("."))
    return path.with_suffix(".py").exists() or (path / "__init__.py").exists()


def test_every_room_has_its_floor():
    rooms = {".".join(module_of(path).split(".")[:2]) for path in files()}
    assert rooms == set(LAYERS)


def upward(path: Path) -> list[str]:
    """The imports of a file that point up."""
    floor = LAYERS.index(room_of(module_of(path)))
    return [name for name in imports(path) if LAYERS.index(room_of(name)) > floor]


@pytest.mark.parametrize("path", files(), ids=lambda path: module_of(path))
def test_imports_point_down(path):
    assert not upward(path)


def test_an_import_that_points_up_is_found(tmp_path, monkeypatch):
    """Also one within a function, of a module by its package, and relative."""
    monkeypatch.setattr("test_house.ROOT", tmp_path)
    for room in ("scene", "tree"):
        (tmp_path / "diffwhitted" / room).mkdir(parents=True)
        (tmp_path / "diffwhitted" / room / "__init__.py").touch()
    (tmp_path / "diffwhitted" / "tree" / "_plan.py").touch()
    low = tmp_path / "diffwhitted" / "scene" / "_low.py"
    low.write_text(
        "def f():\n    from ..tree import _plan, other\n\nfrom ..numerics import safe\nimport diffwhitted.tree\n"
    )
    assert sorted(upward(low)) == ["diffwhitted.tree", "diffwhitted.tree", "diffwhitted.tree._plan"]


@pytest.mark.parametrize("path", files(), ids=lambda path: module_of(path))
def test_a_file_is_small_and_says_what_it_is(path):
    text = path.read_text(encoding="utf-8")
    assert text.count("\n") <= LONGEST
    assert ast.get_docstring(ast.parse(text))


PUBLIC = {
    "diffwhitted": """
        Antialiased Bounded COEFFICIENTS Camera CapacityError Checker Choice ConstantBackground Derivative
        DirectionalLight Effects Explanation GradientBackground InputError KNOBS Knob Material Measured Plan Plane
        PointLight Polygon RayMaps Scene SceneError Settings Sphere antialias choose coefficient_value decide_effects
        derivative explain load_scene measure parse_scene plan ray_maps read_image render render_with_bound
        replace_coefficient save_scene scene_schema write_image
    """,
    "fitting": """
        FitError FitResult FitStage FitStep FitView FittedCoefficient Target Tradeoff fit tradeoff tradeoff_figure
    """,
}
"""What others may rely on. A change of this list is a line in CHANGELOG.md."""


@pytest.mark.parametrize("package", PUBLIC)
def test_public_names(package):
    module = import_module(package)
    assert sorted(module.__all__) == sorted(PUBLIC[package].split())
    assert all(hasattr(module, name) for name in module.__all__)


@pytest.mark.parametrize("name", [f"{package}.{name}" for package in PUBLIC for name in PUBLIC[package].split()])
def test_a_public_name_has_a_docstring_and_an_entry_in_the_reference(name):
    package, _, attribute = name.partition(".")
    thing = getattr(import_module(package), attribute)
    if inspect.isclass(thing) or inspect.isfunction(thing):
        assert len(inspect.getdoc(thing) or "") > 20
        # A dataclass without a docstring gets its signature as one.
        assert not (thing.__doc__ or "").startswith(f"{attribute}(")
    pages = (page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "reference").glob("*.md"))
    assert any(f"::: {name}" in page.splitlines() for page in pages)


def test_importing_does_no_work_of_jax():
    """No device is initialised, nothing is compiled, and no plotting or fitting library is loaded."""
    program = (
        "import sys, diffwhitted, fitting\n"
        "from jax._src import xla_bridge\n"
        "assert not xla_bridge.backends_are_initialized()\n"
        "late = {'matplotlib', 'colour', 'optimistix'} & set(sys.modules)\n"
        "assert not late, late\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")
