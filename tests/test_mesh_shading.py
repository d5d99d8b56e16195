"""Light between the corners of triangles: Gouraud's is a sum over three vertices, fast Phong's a polynomial."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from conftest import SOON_COMPILED
from mesh_samples import ball

import diffwhitted as dw
from diffwhitted.accuracy._knobs import STATED
from diffwhitted.accuracy._survey import swept_knobs
from diffwhitted.accuracy._tracer import Tracer
from diffwhitted.geometry import Corners
from diffwhitted.numerics._vector import vec3
from diffwhitted.shapes import SHADING

CAMERA = dw.Camera(look_from=(0, 0, 4), look_at=(0, 0, 0), up=(0, 1, 0), vfov_deg=20, width=8, height=6)
PLACES = np.asarray([[-4.0, -2.0, 0.3], [4.0, -2.5, -0.2], [0.5, 5.0, 0.1]])
NORMALS = np.asarray([[-0.5, -0.2, 1.0], [0.6, 0.1, 1.0], [0.1, 0.7, 1.0]])
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)


def triangle(shading: str, light, **coefficients) -> dw.Scene:
    """One that fills the picture, in float64."""
    return dw.Scene(
        objects=[dw.Mesh("t", PLACES, [[0, 1, 2]], "paint", normals=NORMALS, shading=shading)],
        materials={"paint": dw.Material(**{"k_h": 0} | coefficients)},
        lights=[light],
        cameras={"main": CAMERA},
        precision="float64",
    )


def picture(scene, camera=CAMERA) -> np.ndarray:
    return np.asarray(dw.render(scene, camera))


def met() -> tuple[np.ndarray, np.ndarray]:
    """Where the rays of the camera meet the triangle (48, 3), and the barycentric coordinates there."""
    half = np.tan(np.radians(10))
    x = (np.arange(8) + 0.5 - 4) / 3 * half
    y = -(np.arange(6) + 0.5 - 3) / 3 * half
    way = np.stack([*np.broadcast_arrays(x[None, :], y[:, None], -1.0)], axis=-1).reshape(-1, 3)
    a, b, c = PLACES
    normal = np.cross(b - a, c - a)
    eye = np.asarray([0, 0, 4.0])
    point = eye + way * (((a - eye) @ normal) / (way @ normal))[:, None]
    shares = np.linalg.solve(np.concatenate([PLACES.T, np.ones((1, 3))])[[0, 1, 3]], np.stack(
        [point[:, 0], point[:, 1], np.ones(len(point))]
    )).T  # fmt: skip
    return point, shares


@pytest.mark.parametrize("highlight", ["halfway", "reflected"])
def test_gouraud_is_the_light_at_the_vertices_by_their_shares(highlight):
    """Hearn and Baker (14-38), (14-39): each vertex with its own normal, way to the lamp, fade and way to the eye."""
    lamp, k_d, k_h, n = np.asarray([2.0, 3.0, 4.0]), np.asarray([0.5, 0.4, 0.3]), 0.6, 7.0
    light = dw.PointLight(lamp, (1, 0.9, 0.8), attenuation=(0.5, 0.2, 0.05))
    at_vertices = []
    for place, normal in zip(PLACES, NORMALS, strict=True):
        away = np.linalg.norm(lamp - place)
        to_light, to_eye = (lamp - place) / away, np.asarray([0, 0, 4.0]) - place
        to_eye = to_eye / np.linalg.norm(to_eye)
        half = (to_light + to_eye) / np.linalg.norm(to_light + to_eye)
        mirrored = 2 * (normal @ to_eye) * normal - to_eye
        cosine = {"halfway": half @ normal, "reflected": mirrored @ to_light}[highlight]
        fade = min(1, 1 / (0.5 + 0.2 * away + 0.05 * away**2))
        lobe = k_h * max(cosine, 0) ** n * (normal @ to_light > 0)
        at_vertices.append(fade * np.asarray([1, 0.9, 0.8]) * (k_d * max(normal @ to_light, 0) + lobe))
    expected = (met()[1] @ np.stack(at_vertices)).reshape(6, 8, 3)
    found = picture(triangle("gouraud", light, k_d=k_d, k_h=k_h, phong_exponent=n, highlight=highlight))
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert expected.std() > 0.008


def test_fast_phong_is_its_polynomial_over_the_triangle():
    """(T5 x + T4 y + T2) x + (T3 y + T1) y + T0 with the T of Bishop and Weimer 1986, from (14-43) to (14-45): x and y
    in the plane of the triangle, from its middle.
    """
    point, _ = met()
    middle = PLACES.mean(axis=0)
    across = (PLACES[1] - PLACES[0]) / np.linalg.norm(PLACES[1] - PLACES[0])
    up = np.cross(np.cross(PLACES[1] - PLACES[0], PLACES[2] - PLACES[0]), across)
    up /= np.linalg.norm(up)
    x, y = ((PLACES - middle) @ axis for axis in (across, up))
    A, B, C = np.linalg.solve(np.stack([x, y, np.ones(3)], axis=1), NORMALS)
    L = np.asarray([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
    a, b, c, d, e, f, g, h, i = (
        L @ A, L @ B, L @ C, A @ A, 2 * A @ B, B @ B, 2 * A @ C, 2 * B @ C, C @ C,
    )  # fmt: skip
    root = np.sqrt(i)
    T5 = (3 * c * g * g - 4 * c * d * i - 4 * a * g * i) / (8 * i * i * root)
    T4 = (3 * c * g * h - 2 * c * e * i - 2 * b * g * i - 2 * a * h * i) / (4 * i * i * root)
    T3 = (3 * c * h * h - 4 * c * f * i - 4 * b * h * i) / (8 * i * i * root)
    T2, T1, T0 = (2 * a * i - c * g) / (2 * i * root), (2 * b * i - c * h) / (2 * i * root), c / root
    px, py = ((point - middle) @ axis for axis in (across, up))
    expected = 0.7 * (T5 * px**2 + T4 * px * py + T3 * py**2 + T2 * px + T1 * py + T0)
    light = dw.DirectionalLight(L, (1, 1, 1))
    found = picture(triangle("fast_phong", light, k_d=0.7))[..., 0].ravel()
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    exact = picture(triangle("phong", light, k_d=0.7))[..., 0].ravel()
    assert 1e-5 < abs(found - exact).max() < 0.02


def test_smaller_triangles_are_nearer_to_phong():
    """Of half the size, a linear light is 4 times as near, a normal of second order 8 times."""

    def off(size):
        rng = np.random.default_rng(2)
        middle, apart, shares = np.asarray([0.2, 0.1, 1.0]), rng.normal(size=(3, 3)), np.asarray([0.2, 0.5, 0.3])
        normals = middle + size * (apart - apart.mean(axis=0))
        smooth = shares @ normals / np.linalg.norm(shares @ normals)
        three = tuple(vec3(jnp.asarray(v)) for v in normals)
        series = Corners(three, three, tuple(jnp.asarray(s) for s in shares)).near_normal().stacked()
        linear = shares @ (normals / np.linalg.norm(normals, axis=1, keepdims=True))
        return np.linalg.norm(linear - smooth), np.linalg.norm(np.asarray(series) - smooth)

    coarse, fine = off(0.04), off(0.02)
    assert coarse[0] / fine[0] == pytest.approx(4, rel=0.1) and coarse[1] / fine[1] == pytest.approx(8, rel=0.1)


def test_normals_that_cancel_out_have_no_series():
    three = tuple(vec3(jnp.asarray(v)) for v in ([1.0, 0, 0], [-1.0, 0, 0], [0.0, 0, 0]))

    def square(share):
        found = Corners(three, three, (share, 1 - share, jnp.zeros(()))).near_normal()
        return found.x**2 + found.y**2 + found.z**2

    assert float(square(0.25)) == 0 and float(jax.grad(square)(0.25)) == 0


# In pictures.


def on_a_ball(shading, shadows="opaque") -> dw.Scene:
    vertices, faces = ball(1)
    return dw.Scene(
        objects=[dw.Mesh("ball", vertices, faces, "clay", shading=shading)],
        materials={"clay": dw.Material(k_a=0.1, k_d=0.6, k_h=0.3, phong_exponent=12)},
        lights=[dw.DirectionalLight((1, 1, 0.3), (1, 1, 1))],
        cameras={"main": CAMERA},
        shadows=shadows,
    )


def test_the_ladder_ends_at_phong():
    found = {shading: picture(on_a_ball(shading)) for shading in SHADING}
    error = [np.sqrt(np.mean((found[shading] - found["phong"]) ** 2)) for shading in SHADING]
    assert error == sorted(error, reverse=True) and error[2] < 0.1 * error[1] and error[3] == 0


@pytest.mark.parametrize("shading", ["gouraud", "fast_phong"])
def test_a_lamp_behind_the_smooth_surface_does_not_reach_it(shading):
    """Where shadows are cast, the line between light and shade is that of Phong; without shadows light runs over it."""
    unlit = (picture(on_a_ball("phong", "off")) <= 0.1 + 1e-6).all(axis=-1)
    assert (picture(on_a_ball(shading))[unlit] <= 0.1 + 1e-6).all() and unlit.any()
    assert shading == "fast_phong" or (picture(on_a_ball(shading, "off"))[unlit] > 0.11).any()


def test_both_are_differentiable():
    """One to the left and one to the right, in vertices, normals, lamp and coefficients at once: forward against a
    central difference and against reverse; finite everywhere.
    """
    corners = {"gouraud": np.asarray([[-9, -9, 0.3], [0, -9, -0.2], [0, 9, 0.1]])}
    corners["fast_phong"] = corners["gouraud"][::-1] * [-1, 1, 1]
    base = dw.Scene(
        objects=[dw.Mesh(s, v, [[0, 1, 2]], "paint", normals=NORMALS, shading=s) for s, v in corners.items()],
        materials={"paint": dw.Material(k_d=0.5, k_h=0.4, phong_exponent=9)},
        lights=[dw.PointLight((2, 3, 4), (1, 1, 1), name="lamp")],
        precision="float64",
    )
    rng = np.random.default_rng(5)
    values = {"light.lamp.position": [2.0, 3, 4], "paint.k_d": 0.5, "paint.k_h": 0.4, "paint.phong_exponent": 9.0}
    for name, places in corners.items():
        values |= {f"object.{name}.vertices": places, f"object.{name}.normals": NORMALS}
    values = {name: jnp.asarray(value) for name, value in values.items()}
    along = {name: jnp.asarray(rng.normal(size=np.shape(value))) for name, value in values.items()}
    weights = jnp.asarray(rng.normal(size=(6, 8, 3)))

    def total(values):
        scene = base
        for name, value in values.items():
            scene = dw.replace_parameter(scene, name, value)
        return (dw.render(scene, CAMERA) * weights).sum()

    def compiled(work):
        return jax.jit(work, compiler_options=SOON_COMPILED)

    found = float(compiled(lambda v: jax.jvp(total, (v,), (along,))[1])(values))
    back, image, step = compiled(jax.grad(total))(values), compiled(total), 1e-6
    assert all(np.isfinite(leaf).all() and np.any(leaf) for leaf in jax.tree.leaves(back))
    other = sum(float((back[name] * along[name]).sum()) for name in values)
    ends = [float(image({name: values[name] + s * along[name] for name in values})) for s in (step, -step)]
    assert found == pytest.approx(other, rel=1e-9) == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)


def test_shading_is_kept_in_files(tmp_path):
    scene = on_a_ball("gouraud")
    dw.save_scene(scene, tmp_path / "scene.toml")
    assert 'shading = "gouraud"' in (tmp_path / "scene.toml").read_text()
    assert dw.load_scene(tmp_path / "scene.toml").objects[0].shading == "gouraud"


# As a knob.


def test_shading_is_a_knob_of_meshes_that_are_not_flat():
    scene = on_a_ball("gouraud", "off")
    tracer = Tracer(scene, CAMERA)
    swept = [[knob.name for knob in swept_knobs(one)] for one in (tracer, Tracer(on_a_ball("flat"), CAMERA))]
    assert "shading" in swept[0] and "shading" not in swept[1]
    assert dw.Settings.of(scene).shading == STATED
    for shading in (STATED, "phong"):
        found = tracer.trace(dw.Settings(shading=shading)).pixels
        expected = picture(on_a_ball("gouraud" if shading == STATED else shading, "off"))
        np.testing.assert_allclose(found.reshape(6, 8, 3), expected, atol=1e-6)
    with pytest.raises(dw.SceneError, match="shading = 'blinn'; allowed is stated, flat, gouraud"):
        dw.Settings(shading="blinn")
