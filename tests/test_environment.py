"""Environments: what rays see of a map or of spherical harmonics, and how these light surfaces.

Against closed formulas, sums over texels, SciPy's harmonics, and central differences.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
import scipy.special
from conftest import SOON_COMPILED
from environment_samples import around, ball_in, directions_of, picture, smooth, weighted_mean

import diffwhitted as dw
import fitting
from diffwhitted.numerics._vector import Vec3, vec3
from diffwhitted.scene.backgrounds._spherical_harmonics import harmonics, lobe_shares, orders, summed

SHINY = np.ones(1, bool)


def seen(background, directions):
    return np.asarray(soon(lambda d: background.seen(vec3(d)).stacked())(jnp.asarray(directions)))


def lit_by(background, directions, exponent=None):
    """The mean about normals, or that of lobes."""
    lit = background.surroundings(SHINY)
    if exponent is None:
        return np.asarray(soon(lambda d: lit.mean(vec3(d)).stacked())(jnp.asarray(directions)))
    exponents = jnp.broadcast_to(jnp.asarray(exponent, float), len(directions))
    return np.asarray(soon(lambda d, n: lit.lobe(vec3(d), n).stacked())(jnp.asarray(directions), exponents))


def soon(work):
    return jax.jit(work, compiler_options=SOON_COMPILED)


def test_harmonics_are_those_of_scipy_without_its_sign():
    """SciPy's complex ones have the Condon-Shortley sign; our pole is +y, our azimuth from -z towards +x."""
    x, y, z = np.moveaxis(around(20), -1, 0)
    ours = np.stack(harmonics(Vec3(*map(jnp.asarray, (x, y, z))), 8))
    polar, azimuth = np.arccos(y), np.arctan2(x, -z)
    for mine, (degree, m) in zip(ours, orders(8), strict=True):
        complex_one = scipy.special.sph_harm_y(degree, abs(m), polar, azimuth) * (-1) ** m
        part = complex_one.real if m >= 0 else complex_one.imag
        np.testing.assert_allclose(mine, part * (np.sqrt(2) if m else 1), atol=1e-12)
    weights = np.random.default_rng(1).normal(size=(81, 3))
    total = summed(jnp.asarray(weights), Vec3(*map(jnp.asarray, (x, y, z)))).stacked()
    np.testing.assert_allclose(total, ours.T @ weights, atol=1e-11)


def test_the_first_nine_by_hand():
    """Constants of Ramamoorthi and Hanrahan 2001, with (x, y, z) there as (-z, x, y) here."""
    d = around(5, seed=2)
    x, y, z = -d[:, 2], d[:, 0], d[:, 1]
    by_hand = [
        0.282095 + 0 * x, 0.488603 * y, 0.488603 * z, 0.488603 * x,
        1.092548 * x * y, 1.092548 * y * z, 0.315392 * (3 * z * z - 1), 1.092548 * x * z, 0.546274 * (x * x - y * y),
    ]  # fmt: skip
    for number in range(9):
        chosen = dw.HarmonicBackground(np.eye(9)[number][:, None] * [1, 2, -3])
        np.testing.assert_allclose(seen(chosen, d), by_hand[number][:, None] * [1, 2, -3], atol=5e-6)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.5, 40.0])
def test_shares_of_a_lobe(exponent):
    for degree, share in enumerate(lobe_shares(exponent, 8)):
        value, _ = scipy.integrate.quad(lambda t, n=degree: t**exponent * scipy.special.eval_legendre(n, t), 0, 1)
        assert float(share) == pytest.approx((exponent + 1) * value, abs=1e-9)


def test_where_things_are_on_the_map():
    """The middle column looks along -z, the top row to +y, the right to +x: a texel is seen where it lies."""
    texels = np.random.default_rng(0).random((8, 16, 3))
    directions = directions_of(8, 16)
    np.testing.assert_allclose(seen(dw.EnvironmentBackground(texels), directions.reshape(-1, 3)), texels.reshape(-1, 3))
    ahead = (texels[3:5, 7:9]).mean(axis=(0, 1))
    np.testing.assert_allclose(seen(dw.EnvironmentBackground(texels), [[0, 0, -1.0]])[0], ahead)
    np.testing.assert_allclose(seen(dw.EnvironmentBackground(texels), [[0, 1.0, 0]])[0], texels[0].mean(axis=0))
    assert directions[4, 12, 0] > 0.9 and directions[0, 0, 1] > 0.9


def test_turned_by_ninety_degrees_it_is_the_map_with_its_columns_moved():
    texels, directions = np.random.default_rng(0).random((32, 64, 3)), around(40)
    turned = dw.EnvironmentBackground(texels, rotation_deg=90, scale=2)
    moved = dw.EnvironmentBackground(2 * np.roll(texels, 16, axis=1))
    np.testing.assert_allclose(seen(turned, directions), seen(moved, directions), atol=1e-12)
    for exponents in (None, np.linspace(0, 300, 40)):
        one, two = lit_by(turned, directions, exponents), lit_by(moved, directions, exponents)
        np.testing.assert_allclose(one, two, atol=1e-12)


def test_across_the_seam_and_the_poles_it_is_continuous_with_finite_derivatives():
    sky = dw.EnvironmentBackground(np.random.default_rng(0).random((8, 16, 3)), rotation_deg=10)
    small = 1e-7
    seam = np.radians(180 + 10)
    sides = [[np.sin(seam + e), 0.3, -np.cos(seam + e)] for e in (-small, small)]
    np.testing.assert_allclose(*seen(sky, sides), atol=1e-5)
    for pole in (1.0, -1.0):
        ring = np.stack([[small * np.sin(a), pole, small * np.cos(a)] for a in np.linspace(0, 6, 7)])
        np.testing.assert_allclose(seen(sky, ring), np.broadcast_to(seen(sky, [[0, pole, 0]]), (7, 3)), atol=1e-5)
    lobes = sky.surroundings(SHINY)

    def all_of(direction):
        d = Vec3(direction[0], direction[1], direction[2])
        parts = sky.seen(d), lobes.mean(d), lobes.lobe(d, jnp.asarray(20.0))
        return jnp.stack([p.stacked() for p in parts])

    at = jnp.asarray([[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 0], *sides, *ring[:2]], float)
    forward, backward = (soon(jax.vmap(derivative(all_of)))(at) for derivative in (jax.jacfwd, jax.jacrev))
    assert np.isfinite(forward).all()
    np.testing.assert_allclose(forward, backward, atol=1e-12)
    step, at = 1e-6, jnp.asarray(around(8))
    ways = jnp.asarray(around(8, seed=1))
    many = soon(jax.vmap(all_of))
    difference = (many(at + step * ways) - many(at - step * ways)) / (2 * step)
    forward = soon(jax.vmap(jax.jacfwd(all_of)))(at)
    np.testing.assert_allclose(jnp.einsum("npkd,nd->npk", forward, ways), difference, atol=1e-5)


def test_irradiance_and_lobes_of_a_smooth_map_are_those_of_sums_over_it():
    directions = np.concatenate([around(12), [[0, 1, 0], [0, -1, 0], [0, 0, 1]]])
    sky, fine = dw.EnvironmentBackground(smooth()), smooth(300)
    for exponent in (None, 1.0, 5.5, 20.0, 90.0):
        expected = np.stack([weighted_mean(fine, d, exponent or 1) for d in directions])
        np.testing.assert_allclose(lit_by(sky, directions, exponent), expected, rtol=4e-3, atol=1e-3)


def test_a_small_lamp_is_lit_within_what_the_guide_says():
    """The hardest map, of one texel: 3.4 % of the largest for irradiance, 3 % for lobes of 2.5 texels or more."""
    texels = np.zeros((64, 128, 3))
    texels[20, 70] = 100
    lamp, sky = directions_of(64, 128)[20, 70], dw.EnvironmentBackground(texels)
    directions = np.stack([lamp + s * around(1, seed=k)[0] for k, s in enumerate((0, 0.03, 0.1, 0.3, 1, 1, 3, 3, 9))])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for exponent in (None, 1, 6, 11, 30, 60):
        expected = np.stack([weighted_mean(texels, d, exponent or 1) for d in directions])
        assert (
            np.abs(lit_by(sky, directions, exponent) - expected).max()
            < (0.034 if exponent is None else 0.03) * expected.max()
        )


def test_a_lobe_of_harmonics_is_exact():
    weights = np.random.default_rng(3).normal(size=(16, 3))
    sky = dw.HarmonicBackground(weights)
    directions = around(6)
    texels = seen(sky, directions_of(400, 800).reshape(-1, 3)).reshape(400, 800, 3)
    for exponent in (None, 7.5):
        expected = np.stack([weighted_mean(texels, d, exponent or 1) for d in directions])
        np.testing.assert_allclose(lit_by(sky, directions, exponent), expected, atol=5e-5)


EVEN = {
    "map": dw.EnvironmentBackground(np.full((16, 32, 3), 0.5), scale=2.0),
    "harmonics": dw.HarmonicBackground([[np.sqrt(4 * np.pi)] * 3, *[[0.0] * 3] * 8]),
}


@pytest.mark.parametrize("kind", EVEN)
def test_an_even_environment_of_one_gives_what_a_material_sends_back(kind):
    """k_d and a stated k_h, exactly; a k_h that is k_s takes no part."""
    scene = dw.Scene(
        objects=[dw.Sphere("left", (-1.1, 0, 0), 1, "gloss"), dw.Sphere("right", (1.1, 0, 0), 1, "mirror")],
        materials={
            "gloss": dw.Material(k_d=(0.3, 0.2, 0.1), k_h=0.25, phong_exponent=12),
            "mirror": dw.Material(k_d=0.3, k_s=0.2, phong_exponent=12),
        },
        background=EVEN[kind], cameras={"main": dw.Camera((0, 0, 6), (0, 0, 0), 40, 8, 6)}, max_depth=2,
        precision="float64",
    )  # fmt: skip
    image = picture(scene)
    np.testing.assert_allclose(image[2, 2], [0.55, 0.45, 0.35], atol=1e-12)
    np.testing.assert_allclose(image[3, 5], 0.5, atol=1e-12)
    np.testing.assert_allclose(image[0, 0], 1, atol=1e-12)
    given = {d.name: d.why for d in dw.decide_effects(scene) if d.on}
    assert given["environment"] == "object 'left': gloss.k_d = [0.3, 0.2, 0.1]"
    assert given["environment_highlight"] == "object 'left': gloss.k_h = 0.25"


def test_what_is_not_called_for_is_off():
    scene = ball_in(EVEN["harmonics"], k_d=0.0, k_s=0.3)
    given = {d.name: d.why for d in dw.decide_effects(scene) if not d.on}
    assert given["environment"] == "no object has k_d > 0"
    assert given["environment_highlight"] == "no object states a k_h > 0"


def test_without_lights_it_is_only_seen():
    dark = ball_in(dw.EnvironmentBackground(smooth(16), lights=False), k_d=0.3, k_h=0.25)
    why = {d.name: (d.on, d.why) for d in dw.decide_effects(dark)}
    assert why["environment"] == why["environment_highlight"] == (False, "the background lights no surface")
    image = picture(dark)
    assert (image[3, 4] == 0).all() and (image[0, 0] > 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["map", "harmonics"])
def test_derivatives_are_those_of_differences(kind):
    """In the numbers of the background and in what it lights."""
    weights = np.random.default_rng(5).normal(size=(9, 3)) * 0.1 + np.eye(9)[0][:, None] * 3
    if kind == "map":
        background = dw.EnvironmentBackground(smooth(16), rotation_deg=33, scale=1.2)
        names = ["background.rotation_deg", "background.scale"]
    else:
        background, names = dw.HarmonicBackground(weights), ["background.harmonics"]
    names += ["paint.k_d", "paint.k_h", "paint.phong_exponent"]
    scene = ball_in(background, k_d=(0.4, 0.3, 0.2), k_h=0.3, phong_exponent=9.3)
    camera = scene.cameras["main"]
    plan = dw.plan(scene, camera, free=tuple(names))
    start = [jnp.asarray(dw.parameter_value(scene, name)) for name in names]
    along = [jnp.asarray(np.random.default_rng(k).normal(size=np.shape(v))) for k, v in enumerate(start)]
    weigh = jnp.asarray(np.random.default_rng(9).random((6, 8, 3)))

    def image(values):
        changed = scene
        for name, value in zip(names, values, strict=True):
            changed = dw.replace_parameter(changed, name, value)
        return jnp.sum(weigh * dw.render(changed, camera, plan=plan))

    value = soon(image)
    forward, backward = soon(lambda v, t: jax.jvp(image, (v,), (t,))[1]), soon(jax.grad(image))(start)
    for number, direction in enumerate(along):
        only = [t if k == number else jnp.zeros_like(t) for k, t in enumerate(along)]
        step = 1e-4
        ends = [value([v + s * t for v, t in zip(start, only, strict=True)]) for s in (-step, step)]
        slope = float(forward(start, only))
        assert slope == pytest.approx(float(ends[1] - ends[0]) / (2 * step), rel=1e-5, abs=1e-7), names[number]
        assert slope == pytest.approx(float(jnp.sum(backward[number] * direction)), rel=1e-9, abs=1e-12)


def test_the_light_is_linear_in_the_texels_with_that_derivative():
    """Traced texels give what known ones do; of a linear function the pulled back weights say its value."""
    rng = np.random.default_rng(0)
    texels, directions = rng.random((16, 32, 3)), around(5)
    at, weights = vec3(jnp.asarray(directions)), jnp.asarray(rng.random((2, 5, 3)))

    def light(texels):
        lit = dw.EnvironmentBackground(texels, rotation_deg=20).surroundings(SHINY)
        return jnp.stack([lit.mean(at).stacked(), lit.lobe(at, jnp.full(5, 30.0)).stacked()])

    def both(texels):
        value, pull = jax.vjp(light, texels)
        return value, pull(weights)[0]

    value, back = soon(both)(jnp.asarray(texels))
    known = dw.EnvironmentBackground(texels, rotation_deg=20)
    np.testing.assert_allclose(value, [lit_by(known, directions), lit_by(known, directions, 30.0)], atol=1e-12)
    assert float((back * texels).sum()) == pytest.approx(float((weights * value).sum()), rel=1e-12)


def test_a_footprint_sees_the_mean_of_the_map_over_its_pixel():
    """White noise of less than a texel a pixel, against 24 x 24 points, also towards a pole."""
    sky = dw.EnvironmentBackground(np.random.default_rng(0).random((128, 256, 3)), lights=False)
    camera = dw.Camera((0, 0, 0), (0.3, 0.8, -1), 60, 8, 6)
    scene = dw.Scene(
        objects=[dw.Sphere("far", (0, -9, 90), 1, "paint")], materials={"paint": dw.Material(k_a=1)}, background=sky,
        cameras={"main": camera},
    )  # fmt: skip
    row, column = ((np.arange(24 * n) + 0.5) / 24 for n in (6, 8))
    rays = camera.rays(jnp.asarray(np.tile(column, len(row))), jnp.asarray(np.repeat(row, len(column))))
    points = seen(sky, rays.direction.stacked()).reshape(6, 24, 8, 24, 3)
    truth, middle = points.mean(axis=(1, 3)), points[:, 12, :, 12]
    filtered = picture(scene, footprint=1)
    assert np.sqrt(np.mean((filtered - truth) ** 2)) < 0.2 * np.sqrt(np.mean((middle - truth) ** 2))


@pytest.mark.parametrize("kind", ["map", "harmonics"])
def test_the_bound_of_what_is_left_out_holds(kind):
    texels = np.full((16, 32, 3), 0.1)
    texels[3:5, 10:13] = 6
    weights = np.random.default_rng(2).normal(size=(16, 3))
    background = dw.EnvironmentBackground(texels) if kind == "map" else dw.HarmonicBackground(weights)
    scene = ball_in(background, "float32", k_d=0.3, k_s=0.3, k_h=0.4, phong_exponent=20)
    scene = dw.Scene(
        objects=[*scene.objects, dw.Plane("ground", (0, 1, 0), -1, "paint")], materials=scene.materials,
        background=background, cameras=scene.cameras, max_depth=5,
    )  # fmt: skip
    bounded = dw.render_with_bound(scene, scene.cameras["main"], cutoff=0.2)
    whole = picture(scene)
    left = np.abs(whole - np.asarray(bounded.image))
    assert left.max() > 1e-3 and (left <= np.asarray(bounded.left_out) * (1 + 1e-5) + 1e-6).all()
    directions = around(500)
    most = background.brightest()
    assert (np.abs(seen(background, directions)) <= most + 1e-9).all()
    assert (np.abs(lit_by(background, directions, 30.0)) <= background.brightest_mean() + 1e-9).all()


@pytest.mark.slow
def test_a_gloss_in_an_unknown_room_is_found_but_for_a_scale_a_channel():
    """Nine coloured harmonics and the material free, the background masked: the ratios and the exponent are found."""
    k_d, k_h, random = (0.3, 0.25, 0.2), (0.4, 0.3, 0.5), np.random.default_rng(4)
    room = np.concatenate([[[4, 3.6, 4.4]], 0.8 * random.normal(size=(8, 3))])
    true = ball_in(dw.HarmonicBackground(room), size=(24, 18), k_d=k_d, k_h=k_h, phong_exponent=6)
    grey = 2 * np.eye(9)[0][:, None] * np.ones(3)
    start = ball_in(dw.HarmonicBackground(grey), size=(24, 18), k_d=(0.5,) * 3, k_h=(0.5,) * 3, phong_exponent=30)
    noisy = picture(true) + 1e-5 * random.normal(size=(18, 24, 3))
    target = fitting.Target(noisy, "main", mask=fitting.only(true, "main", "ball"), noise=1e-5)
    names = ["background.harmonics", "paint.k_d", "paint.k_h", "paint.phong_exponent"]
    found = fitting.fit(start, target, names)
    assert found.status == "not_identifiable" and found.rank == len(found.coefficients) - 3
    assert found["paint.phong_exponent"].identifiable
    assert found["paint.phong_exponent"].value == pytest.approx(6, rel=0.05)
    for channel, part, gloss in zip("rgb", k_d, k_h, strict=True):
        share = found[f"paint.k_h.{channel}"].value / found[f"paint.k_d.{channel}"].value
        assert share == pytest.approx(gloss / part, rel=0.01)
        for name in (f"paint.k_d.{channel}", f"paint.k_h.{channel}", f"background.harmonics.0.{channel}"):
            assert not found[name].identifiable and name in found.message


def test_a_matte_ball_does_not_know_the_harmonics_of_degree_three():
    """A_3 = 0: seven in each channel change no pixel."""
    weights = np.random.default_rng(1).normal(size=(16, 3)) + 2
    matte = ball_in(dw.HarmonicBackground(weights), size=(24, 18), k_d=0.5, k_h=0.0)
    found = fitting.identify(matte, ["background.harmonics"], noise=1e-3, only="ball")
    unknown = {c.name for c in found.coefficients if not c.identifiable}
    assert found.rank == 27
    assert unknown == {f"background.harmonics.{k}.{channel}" for k in range(9, 16) for channel in "rgb"}


def test_a_polished_ball_in_an_even_room_is_as_under_ambient_light():
    """Shirley et al. 1997: R_m / (1 - R0) (1 - (1 - cos)^5), of R0 = 0.04; in the middle of the ball cos = 1."""
    scene = ball_in(EVEN["harmonics"], class_="polished", k_d=0.5, refractive_index=1.5)
    camera = dw.Camera((0, 0, 400), (0, 0, 0), 0.4, 9, 9)
    value = np.asarray(dw.render(scene, camera, max_depth=1))[4]
    height = np.linspace(-4, 4, 9) * 400 * np.tan(np.radians(0.2)) / 4.5
    cosine = np.sqrt(np.maximum(1 - height**2, 0))
    inside = np.abs(height) < 0.95
    expected = 0.5 / (1 - 0.04) * (1 - (1 - cosine) ** 5)
    np.testing.assert_allclose(value[inside, 0], expected[inside], rtol=1e-3)
