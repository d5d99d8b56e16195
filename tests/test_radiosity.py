"""Light between diffuse surfaces: form factors against closed forms, solvers, derivatives, and what is refused."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted._errors import SceneError
from diffwhitted.interreflection import SOLVERS, form_factors, patches_of, solve, towards_polygons

WHITE, RED, GREEN = 0.7, (0.6, 0.1, 0.1), (0.1, 0.5, 0.1)


def square(name: str, height: float, up: bool = True, material: str = "white") -> dw.Polygon:
    corners = [(0, height, 0), (0, height, 1), (1, height, 1), (1, height, 0)]
    return dw.Polygon(name, corners if up else corners[::-1], material)


def wall(name: str, corners, material: str = "white") -> dw.Polygon:
    return dw.Polygon(name, corners, material)


def from_to(factors, one: int, other: int) -> float:
    """The form factor of a whole object, of its patches."""
    area, of = factors.patches.area, factors.patches.object
    sent = area[:, None] * factors.matrix
    return sent[np.ix_(of == one, of == other)].sum() / area[of == one].sum()


def room(patches: int = 60, size: int = 12, radiosity: bool = True, lamp: float = 5.0, **coefficients) -> dw.Scene:
    """A Cornell-like box, open to the camera, with a block in it, and a lamp that is a surface."""
    k_d = {"white": WHITE, "red": RED, "green": GREEN} | coefficients
    walls = [
        wall("floor", [(0, 0, 0), (0, 0, 2), (2, 0, 2), (2, 0, 0)]),
        wall("ceiling", [(0, 2, 0), (2, 2, 0), (2, 2, 2), (0, 2, 2)]),
        wall("back", [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]),
        wall("left", [(0, 0, 0), (0, 2, 0), (0, 2, 2), (0, 0, 2)], "red"),
        wall("right", [(2, 0, 0), (2, 0, 2), (2, 2, 2), (2, 2, 0)], "green"),
        wall("lamp", [(0.6, 1.9, 0.6), (1.4, 1.9, 0.6), (1.4, 1.9, 1.4), (0.6, 1.9, 1.4)], "light"),
    ]
    return dw.Scene(
        objects=[*walls, dw.Box("block", (1.1, 0, 0.6), (1.6, 0.7, 1.2), "white")],
        materials={name: dw.Material(k_d=value) for name, value in k_d.items()} | {"light": dw.Material(emission=lamp)},
        cameras={"main": dw.Camera((1, 1, 5), (1, 1, 0), 38, size, size)},
        radiosity={"patches": patches} if radiosity else None,
        max_depth=1,
        precision="float64",
    )


@pytest.fixture(scope="module")
def lit():
    return dw.radiosity(room())


@pytest.mark.parametrize("patches", [2, 60])
@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (square("other", 1, up=False), 0.1998249),
        (wall("other", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]), 0.2000438),
        # The same, turned the other way: the side counts from which the other square is seen.
        (wall("other", [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)]), 0.2000438),
    ],
    ids=["parallel", "perpendicular", "turned"],
)
def test_two_squares(patches, other, expected):
    """Howell's catalogue, C-11 and C-14."""
    found = form_factors(patches_of([square("one", 0), other], patches), None, None)
    assert found.patches.count >= patches
    assert from_to(found, 0, 1) == pytest.approx(expected, abs=5e-6)


def test_a_disc_above_a_small_patch():
    """r^2 / (r^2 + h^2), by the polygon of the disc's area in its place."""
    disc = patches_of([dw.Disc("disc", (0, 2, 0), (0, -1, 0), 1.5, "white")], 40, np.zeros((1, 3)))
    seen = towards_polygons(np.zeros((1, 3)), np.asarray([[0.0, 1, 0]]), disc.loops).sum()
    assert seen == pytest.approx(1.5**2 / (1.5**2 + 2**2), rel=1e-3)


def test_what_lies_behind_a_point_is_cut_off():
    """A square half below the horizon sends what the upper half sends alone."""
    point, up = np.zeros((1, 3)), np.asarray([[0.0, 1, 0]])
    whole = np.asarray([[[1.0, -1, -1], [1, -1, 1], [1, 1, 1], [1, 1, -1]]])
    upper = np.asarray([[[1.0, 0, -1], [1, 0, 1], [1, 1, 1], [1, 1, -1]]])
    assert towards_polygons(point, up, whole) == pytest.approx(towards_polygons(point, up, upper), rel=1e-9)
    assert towards_polygons(point, up, whole[:, ::-1]) == 0


def test_the_inside_of_a_sphere():
    """F_jk = A_k / A, whatever j."""
    found = form_factors(
        patches_of([dw.Sphere("sphere", (1, 2, 3), 2.0, "white")], 200, np.asarray([[1.0, 2, 3]])), None, None
    )
    share = found.patches.area / found.patches.area.sum()
    others = ~np.eye(len(share), dtype=bool)
    assert found.patches.area.sum() == pytest.approx(16 * np.pi, rel=2e-3)
    assert np.sqrt(np.mean(((found.matrix / share - 1)[others]) ** 2)) < 0.03
    assert found.matrix.sum(axis=1) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_closed_furnace(solver):
    """Every surface sends E and reflects rho: B = E / (1 - rho) everywhere."""
    found = form_factors(
        patches_of([dw.Box("box", (0, 0, 0), (1, 2, 3), "white")], 100, np.full((1, 3), 0.5)), None, None
    )
    assert found.closed.all()
    assert found.residual < 1e-6 and found.imbalance < 1e-3
    one = np.ones((found.patches.count, 3))
    b = jax.jit(lambda rho: solve(found.matrix, found.patches.area, rho, 0.5 * one, solver))(one * [0.2, 0.5, 0.8])
    assert np.asarray(b) == pytest.approx(0.5 / (1 - one * [0.2, 0.5, 0.8]), rel=1e-6)


def test_reciprocity_and_sums(lit):
    sent = np.asarray(lit.form_factors) * lit.areas[:, None]
    assert sent == pytest.approx(sent.T, abs=1e-15)
    sums = np.asarray(lit.form_factors.sum(axis=1))
    assert sums.max() < 1 + 1e-3 and sums.min() > 0.2
    assert lit.closed.any() and not lit.closed.all()
    assert sums[lit.closed] == pytest.approx(1, abs=1e-3)
    assert lit.residual < 1e-3


def test_the_equations_hold(lit):
    b, rho = np.asarray(lit.radiosity), np.asarray(lit.reflectance)
    assert b == pytest.approx(np.asarray(lit.emitted) + rho * (np.asarray(lit.form_factors) @ b), rel=1e-6)
    lamp = lit.object == 5
    assert np.asarray(lit.emitted)[lamp] == pytest.approx(5 * np.pi)
    assert (np.asarray(lit.emitted)[~lamp] == 0).all()


def test_a_block_in_between():
    """A plate between two squares hides all of one from the other; a smaller one hides part."""
    plate = wall("plate", [(-9, 1, -9), (-9, 1, 9), (9, 1, 9), (9, 1, -9)])
    hidden = dw.Scene(
        objects=[square("one", 0), square("other", 2, up=False), plate], materials={"white": dw.Material(k_d=0.5)}
    )
    found = dw.radiosity(hidden, patches=40)
    of = found.object
    assert np.asarray(found.form_factors)[np.ix_(of == 0, of == 1)].sum() == 0
    assert np.asarray(found.form_factors)[np.ix_(of == 0, of == 2)].sum() > 0


def test_solvers_agree(lit):
    for solver in ("direct", "gauss-seidel"):
        other = dw.radiosity(room(), solver=solver)
        assert np.asarray(other.radiosity) == pytest.approx(np.asarray(lit.radiosity), rel=1e-6)


def test_shots_come_nearer(lit):
    """The lamp is shot first; the ambient estimate stands for what is yet to come."""
    whole = np.asarray(lit.radiosity)
    errors = [abs(np.asarray(dw.radiosity(room(), shots=shots).radiosity) - whole).mean() for shots in (4, 20, 200)]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


def test_a_lamp_enters_as_the_ray_tree_has_it():
    """A point lamp far above a floor: E = pi k_d c (N.L), and B without anything else is E."""
    scene = dw.Scene(
        objects=[square("floor", 0)],
        materials={"white": dw.Material(k_d=0.5)},
        lights=[dw.DirectionalLight((0, 1, 1), (2, 1, 0.5))],
    )
    found = dw.radiosity(scene, patches=9)
    assert np.asarray(found.radiosity) == pytest.approx(
        np.pi * 0.5 * 0.5**0.5 * np.asarray([[2, 1, 0.5]] * 9), rel=1e-5
    )
    assert (np.asarray(found.form_factors) == 0).all()


def test_derivatives():
    """Forward against central differences, reverse against forward, for every solver, under jit."""
    scene, step = room(), 1e-5
    at = jnp.asarray(RED), jnp.asarray(5.0)
    along = jnp.asarray([1.0, -0.5, 0.3]), jnp.asarray(0.7)
    for solver in SOLVERS:

        def sent(k, emission, solver=solver):
            changed = dw.replace_coefficient(dw.replace_coefficient(scene, "red.k_d", k), "light.emission", emission)
            return dw.radiosity(changed, solver=solver).radiosity

        value, slope = jax.jit(lambda *a, sent=sent: jax.jvp(sent, a, along))(*at)
        one, other = (sent(*(a + sign * step * t for a, t in zip(at, along, strict=True))) for sign in (1, -1))
        assert np.asarray(slope) == pytest.approx(np.asarray(one - other) / (2 * step), rel=1e-5, abs=1e-6)
        weights = jax.random.normal(jax.random.key(0), value.shape, value.dtype)
        back = jax.jit(jax.grad(lambda *a, sent=sent, weights=weights: (weights * sent(*a)).sum(), (0, 1)))(*at)
        assert sum(float((b * t).sum()) for b, t in zip(back, along, strict=True)) == pytest.approx(
            float((weights * slope).sum()), rel=1e-8
        )


REFUSED = {
    "solver = 'gauss'": lambda: dw.Scene(objects=[], materials={}, radiosity={"solver": "gauss"}),
    "unknown key 'patch'": lambda: dw.Scene(objects=[], materials={}, radiosity={"patch": 5}),
    "patches = 0": lambda: dw.radiosity(room(), patches=0),
    "patches = 1000000": lambda: dw.radiosity(room(), patches=1_000_000),
    "shots = 3 with solver": lambda: dw.radiosity(room(), solver="direct", shots=3),
    "no patches of a plane": lambda: dw.radiosity(
        dw.Scene(objects=[dw.Plane("p", (0, 1, 0), 0, "m")], materials={"m": dw.Material()})
    ),
    "there is no object": lambda: dw.radiosity(dw.Scene(objects=[], materials={})),
    "object 'floor': velocity": lambda: dw.radiosity(
        dw.Scene(objects=[square("floor", 0).moving((1, 0, 0))], materials={"white": dw.Material()})
    ),
    "'white': k_d = 1.2": lambda: dw.radiosity(room(white=1.2)),
    "object 'block': its place or shape is traced": lambda: jax.grad(
        lambda x: dw.radiosity(dw.replace_parameter(room(), "object.block.minimum.x", x)).radiosity.sum()
    )(1.0),
}


@pytest.mark.filterwarnings("ignore::diffwhitted._errors.SceneNote")
@pytest.mark.parametrize("said", REFUSED)
def test_what_is_refused(said):
    with pytest.raises(SceneError) as raised:
        REFUSED[said]()
    assert said in str(raised.value)
