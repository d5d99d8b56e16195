"""Pictures for displays of few levels: dither, halftones and diffusion of errors.

    shown = diffwhitted.display.ordered_dither(diffwhitted.display.fit_range(image), size=4, levels=2)

Pictures are (height, width) or (height, width, 3) of linear light in [0, 1], and so is what comes back: values on
levels that are evenly spaced in linear light.
"""

from .image._diffusion import dot_diffusion, error_diffusion
from .image._dither import dither_matrix, halftone, ordered_dither, random_dither
from .image._levels import fit_range
from .image._palette import write_palette

__all__ = [
    "dither_matrix",
    "dot_diffusion",
    "error_diffusion",
    "fit_range",
    "halftone",
    "ordered_dither",
    "random_dither",
    "write_palette",
]
