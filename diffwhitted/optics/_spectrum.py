"""Refractive indices by wavelength, and the bands of light that a picture is made of.

    Cauchy  n = A + B / λ²,   Sellmeier  n² = 1 + Σ B_i λ² / (λ² - C_i),   Abbe number  V = (n_d - 1) / (n_F - n_C),

λ in micrometres, at the lines d 587.56, F 486.13 and C 656.27 nm.
"""

from functools import cache

import numpy as np
from jaxtyping import Float

LINE_D, LINE_F, LINE_C, LINE_G = 0.5875618, 0.4861327, 0.6562725, 0.4358343
"""Fraunhofer's lines, micrometres."""
RED_GREEN_BLUE = 0.6114, 0.5491, 0.4643
"""Dominant wavelengths of the primaries of Rec. 709 under D65, micrometres: of three bands, one a channel."""
FIRST, LAST = 0.4, 0.7
"""Of more bands: the spectrum from here to there is parted evenly."""


def spread(wavelength):
    """(1/λ² - 1/λ_d²) / (1/λ_F² - 1/λ_C²): by how many parts of n_F - n_C a two-term Cauchy departs from n_d."""
    return (wavelength**-2 - LINE_D**-2) / (LINE_F**-2 - LINE_C**-2)


def cauchy_index(constants, wavelength):
    """A + B / λ² + C / λ⁴ ..., as many terms as there are constants."""
    return sum(constant * wavelength ** (-2 * k) for k, constant in enumerate(constants))


def sellmeier_index(strengths, resonances, wavelength):
    """The root of 1 + Σ B_i λ² / (λ² - C_i), C_i in square micrometres."""
    square = np.asarray(wavelength, np.float64) ** 2
    return np.sqrt(1 + sum(b * square / (square - c) for b, c in zip(strengths, resonances, strict=True)))


def abbe_number(red: float, middle: float, blue: float) -> float:
    """V of the indices at the lines C, d and F."""
    return (middle - 1) / (blue - red)


def wavelengths(bands: int) -> Float[np.ndarray, "bands"]:
    """The middle of each band, micrometres."""
    if bands == 3:
        return np.asarray(RED_GREEN_BLUE)
    edges = np.linspace(FIRST, LAST, bands + 1)
    return (edges[1:] + edges[:-1]) / 2


@cache
def band_weights(bands: int) -> Float[np.ndarray, "bands 3"]:
    """How much the light of each band counts in red, green and blue; of each channel they add up to 1.

    Of three bands each is a channel. Of more: the CIE 1931 matching functions times the illuminant D65 over the band,
    in Rec. 709 primaries (some are negative there: no display shows a spectral colour).
    """
    if bands == 3:
        return np.eye(3)
    import colour  # it takes long to load, and few pictures need it

    matching = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    daylight = colour.SDS_ILLUMINANTS["D65"]
    fine = np.arange(1000 * FIRST, 1000 * LAST) + 0.5
    xyz = matching.copy().interpolate(colour.SpectralShape(400.5, 699.5, 1)).values
    seen = xyz * daylight.copy().interpolate(colour.SpectralShape(400.5, 699.5, 1)).values[:, None]
    rgb = seen @ colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB.T
    band = np.minimum((fine / 1000 - FIRST) / (LAST - FIRST) * bands, bands - 1).astype(int)
    total = np.stack([rgb[band == k].sum(axis=0) for k in range(bands)])
    return total / total.sum(axis=0)
