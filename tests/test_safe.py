"""The safe primitives at and around their edges: value, forward and reverse derivative, in both precisions."""

from decimal import Decimal

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from diffwhitted.illumination import whole_power
from diffwhitted.numerics._safe import length, normalise, power_of_cosine, rescaled, safe_divide, safe_sqrt
from diffwhitted.numerics._vector import SMALL_TABLE, Vec3, lookup

PRECISIONS = ("float32", "float64")
TINY = 1e-30


def value_and_derivatives(function, *arguments):
    """Value and the derivative in every argument, elementwise: forward mode, which reverse mode must repeat."""
    value, transpose = jax.vjp(function, *arguments)
    one, zero = jnp.ones_like(value), [jnp.zeros_like(a) for a in arguments]
    backward = transpose(one)
    forward = []
    for i, argument in enumerate(arguments):
        tangents = [jnp.ones_like(argument) if k == i else zero[k] for k in range(len(arguments))]
        forward.append(jax.jvp(function, arguments, tuple(tangents))[1])
    for ahead, back in zip(forward, backward, strict=True):
        assert np.isfinite(value).all() and np.isfinite(ahead).all() and np.isfinite(back).all()
        assert ahead.dtype == back.dtype == value.dtype == arguments[0].dtype
        np.testing.assert_allclose(ahead, back, rtol=8 * jnp.finfo(value.dtype).eps)
    return value, *forward


def few_roundings(dtype):
    return 8 * float(jnp.finfo(dtype).eps)


@pytest.mark.parametrize("dtype", PRECISIONS)
def test_square_root(dtype):
    x = jnp.asarray([-np.inf, -4, -TINY, -0.0, 0, TINY, 0.25, 4], dtype)
    root, slope = value_and_derivatives(safe_sqrt, x)
    assert root.tolist()[:5] == [0] * 5 and slope.tolist()[:5] == [0] * 5
    np.testing.assert_allclose(root[5:], [1e-15, 0.5, 2], rtol=few_roundings(dtype))
    np.testing.assert_allclose(slope[5:], [5e14, 1, 0.25], rtol=few_roundings(dtype))


@pytest.mark.parametrize("dtype", PRECISIONS)
def test_division(dtype):
    a, b = jnp.asarray([3, 0, 3, 0, -3], dtype), jnp.asarray([0, 0, 2, -2, 1e-15], dtype)
    quotient, in_a, in_b = value_and_derivatives(lambda a, b: safe_divide(a, b, otherwise=7), a, b)
    np.testing.assert_allclose(quotient, [7, 7, 1.5, 0, -3e15], rtol=few_roundings(dtype))
    np.testing.assert_allclose(in_a, [0, 0, 0.5, -0.5, 1e15], rtol=few_roundings(dtype))
    np.testing.assert_allclose(in_b, [0, 0, -0.75, 0, 3e30], rtol=few_roundings(dtype))
    assert safe_divide(a, b).tolist()[:2] == [0, 0]


@pytest.mark.parametrize("dtype", PRECISIONS)
def test_length_and_unit_vector(dtype):
    zero, v = jnp.zeros(3, dtype), jnp.asarray([3.0, 0.0, -4.0], dtype)

    def size(a):
        return length(Vec3(*a))

    def unit(a):
        return normalise(Vec3(*a)).stacked()

    for derivative in (jax.jacfwd, jax.jacrev):
        assert derivative(size)(zero).tolist() == [0, 0, 0]
        assert derivative(unit)(zero).tolist() == np.zeros((3, 3)).tolist()
        np.testing.assert_allclose(derivative(size)(v), [0.6, 0, -0.8], rtol=few_roundings(dtype))
        # d(v/|v|)/dv = (1 - n n^T) / |v|
        expected = (np.eye(3) - np.outer([0.6, 0, -0.8], [0.6, 0, -0.8])) / 5
        np.testing.assert_allclose(derivative(unit)(v), expected, atol=few_roundings(dtype))
    assert (size(zero), size(v)) == (0, 5) and unit(zero).tolist() == [0, 0, 0]
    np.testing.assert_allclose(unit(v), [0.6, 0, -0.8], rtol=few_roundings(dtype))


@pytest.mark.parametrize("dtype", PRECISIONS)
def test_power_of_cosine_around_its_edges(dtype):
    """cos = 1 - chord_squared / 2: at, before and behind 90 degrees, for exponents 0, 1 and 2."""
    apart = jnp.asarray([0, 1, 2, 2.5, 4] * 3, dtype)
    exponent = jnp.asarray([0] * 5 + [1] * 5 + [2] * 5, dtype)
    power, in_chord, in_exponent = value_and_derivatives(power_of_cosine, apart, exponent)
    np.testing.assert_allclose(power, [1, 1, 1, 1, 1, 1, 0.5, 0, 0, 0, 1, 0.25, 0, 0, 0], rtol=few_roundings(dtype))
    np.testing.assert_allclose(
        in_chord, [0] * 5 + [-0.5, -0.5, 0, 0, 0] + [-1, -0.5, 0, 0, 0], rtol=few_roundings(dtype)
    )
    log_half = np.log(0.5)
    np.testing.assert_allclose(
        in_exponent,
        [0, log_half, 0, 0, 0, 0, log_half / 2, 0, 0, 0, 0, log_half / 4, 0, 0, 0],
        rtol=few_roundings(dtype),
    )


@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize("apart", [1e-9, 1e-7, 1e-6, 1e-5])
def test_power_of_cosine_with_an_exponent_of_a_million(dtype, apart):
    stored = Decimal(float(jnp.asarray(apart, dtype)))
    power, in_chord, in_exponent = value_and_derivatives(
        power_of_cosine, jnp.asarray([apart], dtype), jnp.asarray([1e6], dtype)
    )
    cosine = 1 - stored / 2
    exact = cosine**1000000
    np.testing.assert_allclose(power, float(exact), rtol=few_roundings(dtype))
    np.testing.assert_allclose(in_chord, -5e5 * float(exact / cosine), rtol=few_roundings(dtype))
    np.testing.assert_allclose(in_exponent, float(exact * cosine.ln()), rtol=few_roundings(dtype))


@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize("exponent", [0.5, 1, 50, 1e6])
def test_power_of_cosine_just_above_the_horizon_is_finite(dtype, exponent):
    below_two = np.nextafter(np.asarray(2, dtype), np.asarray(0, dtype))
    power, in_chord, in_exponent = value_and_derivatives(
        power_of_cosine, jnp.asarray([below_two]), jnp.asarray([exponent], dtype)
    )
    cosine = (2 - float(below_two)) / 2
    np.testing.assert_allclose(power, cosine**exponent, rtol=100 * few_roundings(dtype), atol=1e-37)
    assert abs(float(in_exponent[0])) <= float(power[0]) * 40 and float(in_chord[0]) <= 0


@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize("base", [0, 0.5, 1, 2])
def test_whole_power(dtype, base):
    count, base = jnp.arange(10), jnp.asarray(base, dtype)
    power, slope = jax.jvp(lambda b: whole_power(b, count, 4), (base,), (jnp.ones_like(base),))
    backward = jax.jacrev(lambda b: whole_power(b, count, 4))(base)
    assert power.dtype == dtype
    np.testing.assert_allclose(power, float(base) ** count, rtol=few_roundings(dtype))
    for derivative in (slope, backward):
        np.testing.assert_allclose(
            derivative, count * float(base) ** np.maximum(count - 1, 0), rtol=few_roundings(dtype)
        )


@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize("rows", [1, SMALL_TABLE, SMALL_TABLE + 1])
def test_lookup_reads_rows_and_sums_their_derivatives(dtype, rows):
    """By selection or by gather: the same rows, and in reverse each row gets the sum of those who read it."""
    column, index = jnp.arange(1.0, rows + 1).astype(dtype), jnp.asarray([0, rows - 1, 0, rows // 2])
    value, transpose = jax.vjp(lambda c: lookup(c, index), column)
    expected = np.asarray(column)[np.asarray(index)]
    assert value.dtype == column.dtype and value.tolist() == expected.tolist()
    tangent = jnp.flip(column)
    forward = jax.jvp(lambda c: lookup(c, index), (column,), (tangent,))[1]
    assert forward.tolist() == np.asarray(tangent)[np.asarray(index)].tolist()
    gathered = np.zeros(rows)
    np.add.at(gathered, np.asarray(index), [1.0, 2.0, 4.0, 8.0])
    assert transpose(jnp.asarray([1, 2, 4, 8], dtype))[0].tolist() == gathered.tolist()


@pytest.mark.parametrize("rows", [3, SMALL_TABLE + 1])
def test_lookup_of_nothing_is_finite(rows):
    """Index -1, a miss, reads some row: finite, so that what is masked later has a finite derivative."""
    table = {"a": jnp.arange(1.0, rows + 1), "b": jnp.arange(2.0 * rows).reshape(rows, 2)}
    found = lookup(table, jnp.asarray([-1, 1]))
    assert np.isfinite(found["a"]).all() and found["b"][1].tolist() == [2, 3]


@pytest.mark.parametrize("dtype", PRECISIONS)
def test_rescaling_keeps_every_digit_and_the_derivative(dtype):
    """The direction of vectors whose squares leave the range; (3, 0, -4) / 5 and its derivative scale as 1 / |v|."""
    smallest, largest = float(jnp.finfo(dtype).tiny), float(jnp.finfo(dtype).max)
    for size in (1.0, 2 * smallest, largest / 8, smallest**0.7, largest**0.7):
        v = Vec3(*(jnp.asarray(size * c, dtype) for c in (3.0, 0.0, -4.0)))
        short, power = rescaled(v)
        assert float(np.log2(float(power))).is_integer()
        assert float(short.z) == float(v.z) * float(power) and 0.5 <= abs(float(short.z)) <= 4
        np.testing.assert_allclose(normalise(short).stacked(), [0.6, 0, -0.8], rtol=few_roundings(dtype))
    slope = jax.jvp(
        lambda a: normalise(rescaled(Vec3(a, a * 0, -4 * a / a))[0]).x,
        (jnp.asarray(3.0, dtype),),
        (jnp.ones((), dtype),),
    )[1]
    np.testing.assert_allclose(slope, 16 / 125, rtol=few_roundings(dtype))
    assert [float(c) for c in rescaled(Vec3(*jnp.zeros((3, 1), dtype)))[0].stacked()[0]] == [0, 0, 0]
