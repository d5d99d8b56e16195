"""Dispersion: each band of the spectrum is a tree of its own, with the index of its wavelength.

The mean of a pixel's samples adds the bands up, each with its weights in red, green and blue. What a coefficient does
to a channel it does to that channel of every band.
"""

from dataclasses import replace

import jax.numpy as jnp

from ..numerics._safe import safe_divide
from ..numerics._vector import Vec3, vec3
from ..optics import band_weights, spread, wavelengths
from ..scene import Tables
from ._plan import Plan
from ._samples import Samples


def at_band(tables: Tables, plan: Plan, samples: Samples) -> Tables:
    """The tables with the indices of the band of the samples:

        n(λ) = n_d + (n_d - 1) / V · (1/λ² - 1/λ_d²) / (1/λ_F² - 1/λ_C²),

    a two-term Cauchy of Abbe number V (0: no dispersion), or the course of a curve that is given.
    """
    if plan.bands == 1:
        return tables
    bent = index = tables.coefficients["refractive_index"]
    if "abbe_number" in tables.coefficients:
        apart = jnp.asarray(spread(wavelengths(plan.bands)), index.dtype)[_band(plan, samples)]
        bent = index + (index - 1) * safe_divide(1, tables.coefficients["abbe_number"]) * apart
    if tables.departures is not None:
        bent = bent + tables.departures[:, _band(plan, samples)].astype(index.dtype)
    return replace(tables, coefficients=tables.coefficients | {"refractive_index": bent})


def of_band(plan: Plan, samples: Samples, dtype) -> Vec3:
    """How much the light of the samples counts in each channel."""
    weights = plan.bands * jnp.asarray(band_weights(plan.bands), dtype)
    return vec3(weights[_band(plan, samples)])


def _band(plan: Plan, samples: Samples):
    return samples.draw % plan.bands
