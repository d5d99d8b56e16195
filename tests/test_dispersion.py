"""Dispersion: indices by wavelength, bands of a picture, a prism and a rainbow."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
import fitting
from diffwhitted.numerics._vector import Vec3
from diffwhitted.optics import (
    band_weights,
    catalogue_lines,
    cauchy_index,
    cauchy_through,
    mirrored,
    refracted,
    sellmeier_index,
    spread,
    wavelengths,
)
from diffwhitted.scene._dispersion import departures, read_dispersion

WIDTH, HEIGHT = 12, 9
BK7 = (1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)
"""Schott's constants of Sellmeier's formula."""


def ball(bands=3, background=None, **glass):
    """A ball of glass before a sky that changes with the height: bent rays move no edge."""
    sky = dw.GradientBackground((0.9, 0.5, 0.1), (0.1, 0.4, 0.9)) if background is None else background
    return dw.Scene(
        objects=[dw.Sphere("ball", (0, 0, 0), 1, "glass")],
        materials={"glass": dw.Material(**({"k_t": 0.9, "k_s": 0.1, "k_h": 0} | glass))},
        cameras={"main": dw.Camera((0, 0.5, 4), (0, 0, 0), 32, WIDTH, HEIGHT)},
        background=sky,
        bands=bands,
        max_depth=4,
        precision="float64",
    )


def picture(scene):
    return np.asarray(dw.render(scene, scene.cameras["main"]))


# Indices


def test_sellmeier_and_catalogue_agree_on_a_known_glass():
    lines = catalogue_lines("n-bk7")
    for wave, index in zip((0.6562725, 0.5875618, 0.4861327, 0.4358343), lines, strict=True):
        assert abs(sellmeier_index(*BK7, wave) - index) < 2e-6
        assert abs(cauchy_index(cauchy_through(lines), wave) - index) < 3e-5
    assert abs((lines[1] - 1) / (lines[2] - lines[0]) - 64.17) < 0.02


def test_cauchy_is_index_and_abbe_number():
    found, curve = read_dispersion({"cauchy": [1.5046, 0.0042]}, "here")
    n_d, abbe = found["refractive_index"], found["abbe_number"]
    for wave in (0.45, 0.55, 0.65):
        np.testing.assert_allclose(n_d + (n_d - 1) / abbe * spread(wave), 1.5046 + 0.0042 / wave**2, rtol=1e-12)
    assert curve is None


def test_a_curve_departs_by_its_formula():
    np.testing.assert_allclose(
        departures(BK7, 8), sellmeier_index(*BK7, wavelengths(8)) - sellmeier_index(*BK7, 0.5875618), atol=1e-15
    )
    assert abs(departures("N-BK7", 8) - departures(BK7, 8)).max() < 1e-4


@pytest.mark.parametrize(
    "stated, message",
    [
        ("N-BK8", "is no substance of the catalogue; there is N-BK7.* Did you mean 'N-BK7'"),
        ({"abbe": 0}, r"dispersion.abbe = 0; allowed is a number > 0"),
        ({"abbe": 60, "cauchy": [1.5, 0.004]}, "allowed is one of"),
        ({"cauchy": [1.5, -0.004]}, r"dispersion.cauchy = \[1.5, -0.004\]; allowed is \[A, B\]"),
        ({"sellmeier": [[1.0], [0.3]]}, "as a resonance in visible light"),
        ({"abbe": "sixty"}, "is not a number"),
    ],
)
def test_what_is_no_dispersion_is_named(stated, message):
    with pytest.raises(dw.SceneError, match=message):
        dw.Material(k_t=1, dispersion=stated)


def test_a_wrong_key_of_the_table_is_named():
    text = '[[material]]\nname = "glass"\nk_t = 1\ndispersion = { abe = 60 }\n'
    with pytest.raises(dw.SceneError, match='unknown key dispersion.abe = 60. Did you mean "abbe"'):
        dw.parse_scene(text)
    with pytest.raises(dw.SceneError, match=r"dispersion = 60; allowed is text in quotes or \{ abbe = a number > 0"):
        dw.parse_scene(text.replace("{ abe = 60 }", "60"))


def test_two_statements_of_one_number_are_refused():
    with pytest.raises(dw.SceneError, match="refractive_index is stated, and dispersion gives it too"):
        dw.Material(k_t=1, refractive_index=1.5, dispersion={"cauchy": [1.5, 0.004]})
    with pytest.raises(dw.SceneError, match="abbe_number is stated, .* class 'metal'"):
        dw.Material(class_="metal", k_s=0.9, dispersion={"abbe": 50})
    with pytest.raises(dw.SceneError, match="bands = 2; allowed is 3 .* or 1"):
        ball(bands=2)


# Nature


def in_plane(x, y):
    return Vec3(jnp.asarray(x), jnp.asarray(y), jnp.zeros_like(jnp.asarray(x)))


@pytest.mark.parametrize(
    "line, wave, angle", [("C", 0.6562725, 42.29), ("F", 0.4861327, 41.43), ("g", 0.4358343, 40.99)]
)
def test_a_rainbow_stands_where_it_is_seen(line, wave, angle):
    """Rays into a drop, reflected once within: 180 degrees less their least deviation."""
    index = cauchy_index(cauchy_through(catalogue_lines("water")), wave)
    height = jnp.linspace(0.8, 0.9, 20001)
    direction, normal = (
        in_plane(jnp.ones_like(height), jnp.zeros_like(height)),
        in_plane(-jnp.sqrt(1 - height**2), height),
    )
    inside = refracted(direction, normal, 1 / index)
    # A ray in a circle meets it again 2 cos(r) further on.
    for turn in (mirrored, lambda u, n: refracted(u, n, index)):
        cosine = -(inside.x * normal.x + inside.y * normal.y)
        point = normal + inside * (2 * cosine)
        inside, normal = turn(inside, -point), point
    deviation = np.degrees(np.arctan2(inside.y, inside.x)) % 360
    assert (
        abs(180 - abs(180 - deviation).min() - (180 - angle)) < 0.02 or abs(abs(180 - deviation).max() - angle) < 0.02
    )


def test_a_prism_deviates_least_by_its_formula():
    """n = sin((a + D) / 2) / sin(a / 2), through faces of 60 degrees."""
    apex, index = np.radians(60), catalogue_lines("N-SF11")[1]
    incidence = jnp.linspace(0.9, 1.4, 20001)
    one, along = jnp.ones_like(incidence), incidence - apex / 2
    left, right = (in_plane(side * np.cos(apex / 2) * one, np.sin(apex / 2) * one) for side in (-1, 1))
    direction = in_plane(jnp.cos(along), jnp.sin(along))
    out = refracted(refracted(direction, left, 1 / index), -right, index)
    least = np.degrees(np.arccos(direction.x * out.x + direction.y * out.y)).min()
    np.testing.assert_allclose(least, np.degrees(2 * np.arcsin(index * np.sin(apex / 2)) - apex), atol=1e-4)


# Pictures


def test_three_bands_are_the_channels_of_three_indices():
    found, abbe = picture(ball(refractive_index=1.6, dispersion={"abbe": 15})), 15
    for channel, wave in enumerate(wavelengths(3)):
        alone = picture(ball(refractive_index=1.6 + 0.6 / abbe * spread(wave)))
        np.testing.assert_allclose(found[..., channel], alone[..., channel], atol=1e-12)
    assert np.ptp(found - picture(ball(refractive_index=1.6))) > 1e-3


def test_more_bands_are_the_weighted_sum_of_their_pictures():
    waves, weights = wavelengths(5), band_weights(5)
    np.testing.assert_allclose(weights.sum(axis=0), 1, atol=1e-12)
    expected = sum(
        picture(ball(refractive_index=n)) * weight
        for n, weight in zip(1.5168 + departures("N-BK7", 5), weights, strict=True)
    )
    assert len(waves) == 5
    np.testing.assert_allclose(picture(ball(bands=5, dispersion="N-BK7")), expected, atol=2e-6)


def test_without_dispersion_bands_change_nothing():
    one, many = (dw.plan(s, s.cameras["main"]) for s in (ball(bands=3), ball(bands=9)))
    assert one.program == many.program and one.bands == 1
    assert "dispersion" not in one.effects and "dispersion" in make(ball(dispersion={"abbe": 40}))


def make(scene):
    return dw.plan(scene, scene.cameras["main"]).effects


def test_derivative_in_the_abbe_number():
    scene = ball(refractive_index=1.6, dispersion={"abbe": 15})
    plan = dw.plan(scene, scene.cameras["main"])

    def image(abbe):
        return dw.render(dw.replace_parameter(scene, "glass.abbe_number", abbe), scene.cameras["main"], plan=plan)

    both = jax.jit(lambda v: jax.jvp(image, (v,), (jnp.ones_like(v),)))
    slope = np.asarray(both(jnp.asarray(15.0))[1])
    difference, wider = (np.asarray(both(15 + h)[0] - both(15 - h)[0]) / (2 * h) for h in (1e-4, 2e-4))
    smooth = abs(difference - wider) < 1e-6
    assert smooth.mean() > 0.9 and abs(slope).max() > 1e-4
    np.testing.assert_allclose(slope[smooth], difference[smooth], atol=1e-6)


def test_an_abbe_number_is_found():
    truth = ball(refractive_index=1.6, dispersion={"abbe": 25})
    found = fitting.fit(
        ball(refractive_index=1.58, dispersion={"abbe": 60}),
        dw.render(truth, truth.cameras["main"], samples=4),
        free=("glass.abbe_number", "glass.refractive_index"),
        footprint=1,
    )
    by_name = {c.name: c for c in found.coefficients}
    assert abs(by_name["glass.refractive_index"].value - 1.6) < 5e-3
    assert abs(by_name["glass.abbe_number"].value - 25) < 4


def test_a_file_keeps_the_dispersion(tmp_path):
    for glass in ({"dispersion": "N-BK7"}, {"dispersion": {"sellmeier": BK7}}, {"dispersion": {"abbe": 40}}):
        scene = ball(bands=5, **glass)
        dw.save_scene(scene, tmp_path / "s.toml")
        again = dw.load_scene(tmp_path / "s.toml", precision="float64")
        assert again.materials["glass"].curve == scene.materials["glass"].curve and again.bands == 5
        assert jax.tree.all(jax.tree.map(lambda a, b: bool((a == b).all()), scene, again))
