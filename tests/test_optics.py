"""How rays bend: Snell's law by table and by Whitted's form, the critical angle, grazing incidence, and index ratio
1.
"""

import json
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from diffwhitted.numerics._vector import Vec3, dot, vec3
from diffwhitted.optics import eta_at, mirrored, refracted, refraction_radicand

ORACLES = Path(__file__).parent / "oracles"
ROWS = json.loads((ORACLES / "fresnel.json").read_text())["rows"]
BENT = [row for row in ROWS if not row["tir"]]
TOTAL = [row for row in ROWS if row["tir"]]
UP = vec3(jnp.asarray([0.0, 1.0, 0.0]))


def column(rows, name):
    return np.asarray([row[name] for row in rows], float)


def downwards(angle):
    """Unit directions that meet the plane y = 0 from above, `angle` (radians) off its normal."""
    angle = np.asarray(angle, float)
    return vec3(jnp.asarray(np.stack([np.sin(angle), -np.cos(angle), 0 * angle], axis=-1)))


def etas(rows):
    return jnp.asarray(column(rows, "n1") / column(rows, "n2"))


def whitted_direction(u, normal, index):
    """Whitted's P = k_f (N + V') - N with V' = u / |u.N| and k_f = (index**2 |V'|**2 - |V' + N|**2)**(-1/2), made
    unit.
    """
    v = u / np.abs((u * normal).sum(-1, keepdims=True))
    k_f = (index**2 * (v * v).sum(-1, keepdims=True) - ((v + normal) ** 2).sum(-1, keepdims=True)) ** -0.5
    p = k_f * (normal + v) - normal
    return p / np.linalg.norm(p, axis=-1, keepdims=True)


def test_refracted_angles_of_the_table():
    """96 rows of indices and angles; the angles are given to 1e-6 degrees."""
    bent = refracted(downwards(np.radians(column(BENT, "angle_deg"))), UP, etas(BENT))
    angle = np.degrees(np.arctan2(bent.x, -bent.y))
    np.testing.assert_allclose(angle, column(BENT, "theta_t_deg"), atol=1e-6)
    np.testing.assert_allclose(dot(bent, bent), 1, rtol=1e-14)
    assert (bent.z == 0).all()


def test_the_table_reflects_totally_where_the_radicand_is_negative():
    for rows, sign in ((BENT, 1), (TOTAL, -1)):
        radicand = refraction_radicand(jnp.cos(jnp.radians(column(rows, "angle_deg"))), etas(rows))
        assert (np.sign(radicand) == sign).all() and len(rows) > 20


def test_whitted_form_agrees_with_hearn_and_baker():
    random = np.random.default_rng(0)
    normal, u = random.normal(size=(2, 400, 3))
    normal, u = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (normal, u))
    u = np.where((u * normal).sum(-1, keepdims=True) > 0, -u, u)
    eta = random.uniform(0.4, 1.8, size=400)
    radicand = 1 - eta**2 * (1 - (u * normal).sum(-1) ** 2)
    keep = radicand > 1e-3
    ours = refracted(vec3(jnp.asarray(u)), vec3(jnp.asarray(normal)), jnp.asarray(eta)).stacked()
    theirs = whitted_direction(u[keep], normal[keep], 1 / eta[keep, None])
    assert 200 < keep.sum() < 400
    np.testing.assert_allclose(ours[keep], theirs, atol=1e-12)


def test_radicand_is_that_of_the_book():
    """cos_r**2 = 1 - eta**2 (1 - cos_i**2), equation 14-51, in the rewritten form."""
    cos_i, eta = (g.reshape(-1) for g in np.meshgrid(np.linspace(0, 1, 21), [0.4, 0.75, 1, 1.33, 2.4]))
    np.testing.assert_allclose(
        refraction_radicand(jnp.asarray(cos_i), jnp.asarray(eta)), 1 - eta**2 * (1 - cos_i**2), atol=1e-14
    )


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("index", [1.001, 1.33, 1.5, 2.417])
def test_critical_angle_from_both_sides(index, dtype):
    """sin(critical) = 1 / index: just below it a ray leaves nearly along the surface, just above it none does."""
    critical, little = np.arcsin(1 / index), 2e-3
    below, above = (downwards(critical + sign * little) for sign in (-1, 1))
    below, above, up = jax.tree.map(lambda a: a.astype(dtype), (below, above, UP))
    eta = jnp.asarray(index, dtype)
    leaves = refracted(below, up, eta)
    expected = np.arcsin(index * np.sin(critical - little))
    np.testing.assert_allclose(
        np.arctan2(leaves.x, -leaves.y), expected, atol=2e-7 if dtype == "float32" else 1e-13, rtol=1e-5
    )
    assert refraction_radicand(-above.y, eta) < 0 < refraction_radicand(-below.y, eta)
    for direction in (below, above):
        in_direction, in_eta = jax.jacfwd(lambda u, e: refracted(u, up, e).stacked(), argnums=(0, 1))(direction, eta)
        assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves((in_direction, in_eta)))


def test_exactly_at_the_critical_angle():
    """Index 5/4 at sin = 4/5: the ray leaves along the surface, with finite derivatives both ways."""
    u = vec3(jnp.asarray([0.8, -0.6, 0.0]))

    def bent(eta):
        return refracted(u, UP, eta).stacked()

    # The edge itself, with a radicand of exactly 0, lies within a rounding of 1.25.
    etas = [1.25, np.nextafter(1.25, 0), np.nextafter(1.25, 2)]
    for eta in etas:
        np.testing.assert_allclose(bent(eta), [1, 0, 0], atol=1e-7)
        for mode in (jax.jacfwd, jax.jacrev):
            assert np.isfinite(mode(bent)(eta)).all()
    edge = refracted(vec3(jnp.asarray([1.0, 0.0, 0.0])), UP, 1.0)
    assert edge.stacked().tolist() == [1, 0, 0]


@pytest.mark.parametrize("eta", [1 / 1.5, 1.0])
def test_grazing_incidence(eta):
    """Along the surface: into the denser side at the critical angle, and straight on without a change of index."""
    for glance in (0.0, 1e-12, 1e-6):
        bent = refracted(downwards(np.pi / 2 - glance), UP, eta)
        np.testing.assert_allclose(bent.x, eta, rtol=1e-10)
        np.testing.assert_allclose(-bent.y, np.sqrt(1 - eta**2 * np.cos(glance) ** 2), atol=2e-8)
        np.testing.assert_allclose(
            mirrored(downwards(np.pi / 2 - glance), UP).stacked(), [np.cos(glance), np.sin(glance), 0], atol=1e-15
        )


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_index_ratio_of_one_changes_nothing(dtype):
    """Straight on to the last digits, without a total reflection at any angle, and with the derivative of the limit."""
    random = np.random.default_rng(5)
    u = random.normal(size=(1000, 3))
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    u[:, 1] = -np.abs(u[:, 1])
    u[0] = (1, 0, 0)
    directions, up = vec3(jnp.asarray(u, dtype)), jax.tree.map(lambda a: a.astype(dtype), UP)
    eta = eta_at(True, jnp.asarray(1.5, dtype), jnp.asarray(1.5, dtype))
    assert eta == 1
    np.testing.assert_allclose(
        refracted(directions, up, eta).stacked(), u.astype(dtype), atol=3 * float(jnp.finfo(dtype).eps)
    )
    assert (refraction_radicand(-directions.y, eta) >= 0).all()
    # dT/d eta = u + (cos_i + tan_i sin_i) N at eta = 1, from (14-50) and d cos_r / d eta = -sin_i**2 / cos_i
    slope = jax.jvp(lambda e: refracted(directions, up, e).stacked(), (eta,), (jnp.ones_like(eta),))[1]
    cosine = -u[1:, 1]
    expected = u[1:].copy()
    expected[:, 1] += cosine + (1 - cosine**2) / cosine
    np.testing.assert_allclose(slope[1:], expected, rtol=2e-2 if dtype == "float32" else 1e-8, atol=1e-6)
    assert np.isfinite(slope).all()


def test_eta_is_the_index_of_the_ray_over_the_other():
    assert eta_at(jnp.asarray([True, False]), jnp.asarray(1.5), jnp.asarray(1.2)).tolist() == pytest.approx([0.8, 1.25])


def test_there_and_back_again():
    """A ray that goes in and comes back the way it went leaves the way it came (Snell reversed)."""
    angle = np.radians(np.arange(0, 90, 5.0))
    into = refracted(downwards(angle), UP, jnp.asarray(1 / 1.7))
    back = refracted(-into, -UP, jnp.asarray(1.7))
    np.testing.assert_allclose((-back).stacked(), downwards(angle).stacked(), atol=1e-12)


def test_mirror_direction():
    """The reflected vector of the book, equal angles for random rays, and either sign of the normal."""
    case = json.loads((ORACLES / "ray_tracer_challenge.json").read_text())["geometry"]["reflection_vector"]
    u, n = (vec3(jnp.asarray(case[k], float)) for k in ("ray_direction", "plane_normal"))
    np.testing.assert_allclose(mirrored(u, n).stacked(), case["reflected"], atol=1e-15)
    random = np.random.default_rng(6).normal(size=(2, 100, 3))
    u, n = (vec3(jnp.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))) for v in random)
    r = mirrored(u, n)
    assert mirrored(u, -n).stacked().tolist() == r.stacked().tolist()
    np.testing.assert_allclose(dot(r, n), -dot(u, n), atol=1e-15)
    np.testing.assert_allclose(dot(r, r), 1, rtol=1e-14)
    tangential = Vec3(*(getattr(u, k) - getattr(n, k) * dot(u, n) for k in "xyz"))
    np.testing.assert_allclose(dot(r, tangential), dot(u, tangential), atol=1e-15)
