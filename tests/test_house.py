"""The house: imports point one way, public names are documented ones, files stay small, importing is cheap."""

import ast
import cProfile
import inspect
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import unknown_kinds

import diffwhitted
import fitting
from diffwhitted._errors import SceneError, SceneNote
from diffwhitted.shapes import OBJECTS
from diffwhitted.tree import make_plan

ROOT = Path(__file__).parents[1]
LONGEST = 300
"""Lines of a file."""

LAYERS = (
    "diffwhitted._errors",
    "diffwhitted._files",
    "diffwhitted._lazily",
    "diffwhitted.numerics",
    "diffwhitted.optics",
    "diffwhitted.geometry",
    "diffwhitted.records",
    "diffwhitted.shapes",
    "diffwhitted.interreflection",
    "diffwhitted.scene",
    "diffwhitted.illumination",
    "diffwhitted.tree",
    "diffwhitted.image",
    "diffwhitted.display",
    "diffwhitted.rendering",
    "diffwhitted.cost",
    "diffwhitted.accuracy",
    "diffwhitted._render",
    "diffwhitted._radiosity",
    "diffwhitted.standard",
    "diffwhitted.formats",
    "diffwhitted",
    "fitting._errors",
    "fitting._coefficients",
    "fitting._held_out",
    "fitting._result",
    "fitting.problem",
    "fitting.judging",
    "fitting.solving",
    "fitting._judged",
    "fitting._outcome",
    "fitting._restricted",
    "fitting._prediction",
    "fitting._fit",
    "fitting._fit_texture",
    "fitting.planning",
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
        Antialiased Bounded Box COEFFICIENTS Camera CapacityError Checker Choice Cone ConstantBackground
        Cylinder Derivative Dimples DirectionalLight Disc Effects EnvironmentBackground Explanation FarFromOrigin
        GradientBackground HarmonicBackground Hemisphere ImageTexture InputError KNOBS Knob Layers Material PatchLight
        Measured Mesh Noise OrthographicCamera Parameter Patch Plan Plane PointLight Polygon Polyhedron Quadric RayMaps
        RectangleLight Scene SceneError Settings Shot Sphere SphereLight SphereSet SpotLight Torus WarnLight Waves
        antialias choose coefficient_value decide_effects derivative explain layers load_scene measure
        parameter_value parameters parse_scene plan radiosity ray_maps read_cameras read_image render render_with_bound
        replace_coefficient replace_parameter save_scene scene_schema standard_scene write_image
    """,
    "fitting": """
        FitError FitResult FitStage FitStep FitView FittedCoefficient HeldOut Identification
        Suggestion Target TextureFit Tradeoff WildPixel fit fit_texture identify only suggest tradeoff tradeoff_figure
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
        "import sys, diffwhitted, fitting\nfrom jax._src import xla_bridge\n"
        "assert not xla_bridge.backends_are_initialized()\n"
        "late = {'matplotlib', 'colour', 'optimistix'} & set(sys.modules)\n"
        "assert not late, late\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")


# A kind that the package does not have is one class or one row, and everything takes it.


@pytest.fixture(scope="module")
def strange():
    """A scene of kinds that were registered a moment ago."""
    with unknown_kinds.known():
        yield diffwhitted.parse_scene(unknown_kinds.TOML)


@pytest.fixture(scope="module")
def picture(strange):
    return np.asarray(diffwhitted.render(strange, strange.cameras["main"]))


def test_a_new_kind_is_refused_where_it_is_not_registered():
    with pytest.raises(SceneError, match="dawn"):
        diffwhitted.parse_scene(unknown_kinds.TOML)


def test_a_registry_refuses_what_breaks_its_contract():
    class Nameless(unknown_kinds.Coin):
        TYPE = "sphere"

    with pytest.raises(TypeError, match="the name 'sphere' is that of Sphere"):
        OBJECTS.register(Nameless)
    with pytest.raises(TypeError, match="breaks the contract AbstractObject"):
        OBJECTS.register(unknown_kinds.Beacon)


def test_a_scene_refuses_what_is_of_no_kind():
    with pytest.raises(SceneError, match="a tuple is no background; allowed is ConstantBackground, GradientBackground"):
        diffwhitted.Scene(objects=[], materials={}, background=(0, 0, 1))


def test_a_new_kind_renders_what_its_formulas_say(strange, picture):
    """The pixel in the middle of the plate, and the background, by hand."""
    camera = strange.cameras["main"]
    rays = camera.rays(np.asarray([8.5, 0.5]), np.asarray([11.5, 0.5]))
    origin, ways = np.asarray([0.0, 1.0, 5.0]), np.asarray(rays.direction.stacked(), np.float64)
    normal = np.asarray([0.1, 1.0, 0.2]) / np.linalg.norm([0.1, 1.0, 0.2])
    point = origin + ways[0] * (normal @ ([0, -0.5, 0] - origin)) / (normal @ ways[0])
    to_light = np.asarray([2.0, 4.0, 3.0]) - point
    to_light /= np.linalg.norm(to_light)
    axis = np.asarray([-1.0, -2.0, -1.0]) / np.sqrt(6)
    arrives = np.asarray([0.9, 0.8, 0.7]) * 0.5 * (1 - to_light @ axis)
    waves = 1 + 0.3 * np.sin(2 * np.pi * point[0] / 0.8)
    expected = 0.1 + np.asarray([0.5, 0.4, 0.3]) * waves * (normal @ to_light) * arrives
    np.testing.assert_allclose(picture[11, 8], expected, rtol=2e-5)
    np.testing.assert_allclose(picture[0, 0], np.asarray([0.2, 0.3, 0.4]) * 0.5 * (1 + ways[1, 0]), rtol=1e-5)


def test_a_new_camera_turns_crops_and_has_names(strange):
    """A quarter of the columns right of the middle it looks to +x, a quarter of the rows below it down by 1/2."""
    camera = jax.tree.map(jnp.asarray, strange.cameras["around"])
    ray = camera.rays(jnp.asarray([8.0, 14.0]), jnp.asarray([9.0, 13.5]))
    np.testing.assert_allclose(ray.direction.stacked(), [[0, 0, -1], np.asarray([2, -1, 0]) / np.sqrt(5)], atol=1e-6)
    assert "camera.around.stretch" in [parameter.name for parameter in diffwhitted.parameters(strange)]
    wider = diffwhitted.replace_parameter(strange, "camera.around.stretch", 4.0).cameras["around"]
    assert (wider.width, wider.full, float(wider.stretch)) == (16, (24, 18), 4.0)


@pytest.mark.parametrize(
    "name", ["paint.k_e", "light.tower.colour.g", "texture.waves.depth", "background.colour.b", "object.plate.normal.x"]
)
def test_a_new_kind_is_differentiated(strange, name):
    """Against a central difference; at points of the plate, where no edge is near."""
    camera = strange.cameras["main"]
    value = float(np.ravel(diffwhitted.coefficient_value(strange, name))[0])

    def seen(number):
        image = diffwhitted.render(diffwhitted.replace_coefficient(strange, name, number), camera)
        return jnp.stack([image[11, 8], image[12, 6], image[0, 0]]).sum()

    step = 1e-3
    central = (float(seen(value + step)) - float(seen(value - step))) / (2 * step)
    assert float(jax.jvp(seen, (value,), (1.0,))[1]) == pytest.approx(central, rel=2e-3, abs=1e-4)


def test_a_new_kind_is_saved_and_loaded(strange, picture, tmp_path):
    diffwhitted.save_scene(strange, tmp_path / "strange.toml")
    again = diffwhitted.load_scene(tmp_path / "strange.toml")
    assert eqx.tree_equal(again, strange)


def test_what_a_new_kind_may_send_is_bounded_or_the_bound_is_infinite(strange):
    """The beacon states no brightest light, so where its light may be missed there is no finite bound."""
    camera = strange.cameras["main"]
    shallow = diffwhitted.render_with_bound(strange, camera, max_depth=1)
    deep = np.asarray(diffwhitted.render(strange, camera, max_depth=8))
    assert np.isinf(shallow.most) and (shallow.left_out[deep > shallow.image + 1e-6] == np.inf).all()


def test_a_new_effect_is_explained(strange):
    decided = {d.name: d for d in diffwhitted.decide_effects(strange)}
    assert decided["glow"].on and "k_e = 0.1" in decided["glow"].why
    dark = diffwhitted.replace_coefficient(strange, "paint.k_e", 0.0)
    assert not {d.name: d for d in diffwhitted.decide_effects(dark)}["glow"].on


@pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
def test_a_new_kind_knows_points_only_until_it_states_a_footprint(strange):
    camera = strange.cameras["main"]
    with pytest.warns(SceneNote, match=r"object 'plate' \(coin\) knows points only, so 4 x 4 points"):
        averaged = diffwhitted.render(strange, camera, footprint=1)
    np.testing.assert_array_equal(averaged, diffwhitted.render(strange, camera, samples=4))


def test_numbers_of_a_new_kind_are_fitted(strange, picture):
    free = ["paint.k_e", "steel.k_s", "light.tower.colour"]
    start = {"paint.k_e": 0.5, "steel.k_s": 0.1, "light.tower.colour": 0.5}
    result = fitting.fit(strange, picture, free=free, start=start)
    found = {c.name: c.value for c in result.coefficients}
    assert found["paint.k_e"] == pytest.approx(0.1, abs=1e-4) and found["steel.k_s"] == pytest.approx(0.4, abs=1e-4)
    assert found["light.tower.colour.r"] == pytest.approx(0.9, abs=1e-3)


def test_a_fit_that_moves_the_edges_of_a_kind_without_a_footprint_is_refused(strange, picture):
    with pytest.raises(fitting.FitError, match=r"object.plate.radius.* moves edges .* object 'plate' \(coin\)"):
        fitting.fit(strange, picture, free=["object.plate.radius"])


# Thousands of objects, and programs that know none of them by name.


def crowd(count: int, material: str = "m0", named: str = "ball", k_d: float = 0.5) -> diffwhitted.Scene:
    """Spheres on a lattice, all of one of two materials, of which the second is half as bright."""
    side = int(np.ceil(count ** (1 / 3)))
    middle = np.full(3, 1.5 * (side - 1))
    places = np.stack(np.meshgrid(*[np.arange(side) * 3.0] * 3), axis=-1).reshape(-1, 3)[:count]
    first, second = (material.replace(end, number) for end, number in ((material[-1], "0"), (material[-1], "1")))
    return diffwhitted.Scene(
        objects=[diffwhitted.Sphere(f"{named} {i}", place, 1.0, material) for i, place in enumerate(places)],
        materials={first: diffwhitted.Material(k_d=k_d), second: diffwhitted.Material(k_d=k_d / 2, k_a=0.0)},
        lights=[diffwhitted.PointLight((0, 200, 0), (1, 1, 1))],
        cameras={"main": diffwhitted.Camera(middle + [2 * side, 3 * side, 5 * side], middle, 40, 8, 6)},
    )


def test_the_work_to_build_and_plan_grows_no_faster_than_the_objects():
    """Calls of Python in all that is done before a picture, counted: an object more costs the same at 500 and 2000."""

    def calls(count: int) -> int:
        profile = cProfile.Profile()
        profile.enable()
        scene = crowd(count)
        make_plan(scene, scene.cameras["main"], capacity=64)
        profile.disable()
        return sum(entry.callcount for entry in profile.getstats())

    calls(50)
    few, some, many = (calls(count) for count in (500, 1000, 2000))
    assert many - some < 2.2 * (some - few) and (many - some) / 1000 < 600


COMPILED: list[str] = []


@pytest.fixture(scope="module")
def compiled():
    """What has been compiled since it was last cleared."""
    jax.monitoring.register_event_duration_secs_listener(
        lambda event, seconds, **about: COMPILED.append(event) if "backend_compile" in event else None
    )
    COMPILED.clear()
    return COMPILED


def test_names_and_materials_are_no_part_of_a_program(compiled):
    """Another name, another material, other numbers: nothing is compiled for a picture; other names, numbers and
    bounds: nothing for a fit.
    """
    camera = crowd(12).cameras["main"]
    first = np.asarray(diffwhitted.render(crowd(12), camera))
    assert first.max() > 0.1
    fitting.fit(crowd(12), first, free=["m0.k_d"], start={"m0.k_d": 0.4})
    assert len(compiled) > 2
    compiled.clear()
    second = np.asarray(diffwhitted.render(crowd(12, "m1", "thing"), camera))
    np.testing.assert_allclose(second, first / 2, atol=1e-6)
    other = crowd(12, "paint0", "thing", k_d=0.8)
    start, bounds = {"paint0.k_d": 0.6}, {"paint0.k_d": (0.1, 0.9)}
    found = fitting.fit(other, second, free=["paint0.k_d"], start=start, bounds=bounds)
    assert found["paint0.k_d"].value == pytest.approx(0.25, abs=1e-5)
    assert not compiled
