"""What the parts of a material of Mitsuba send back together."""

from dataclasses import dataclass, field

import numpy as np

from ._tags import Tag


@dataclass
class Sum:
    """What the parts of a material send back together."""

    solid: bool
    k_d: np.ndarray = field(default_factory=lambda: np.zeros(3))
    k_s: np.ndarray = field(default_factory=lambda: np.zeros(3))
    k_t: np.ndarray = field(default_factory=lambda: np.zeros(3))
    k_h: np.ndarray = field(default_factory=lambda: np.zeros(3))
    exponent: float | None = None
    reflected: bool = False
    index: float = 1.0
    glass: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    """What glass of that index lets through and mirrors, before Fresnel's shares."""
    metal: bool = False
    """It mirrors straight on what k_s says, and more along the surface."""
    boards: list[tuple[Tag, np.ndarray]] = field(default_factory=list)
    """Checkerboards of diffuse light, and their two colours (2, 3)."""

    def shine(self, k_h: np.ndarray, exponent: float) -> None:
        if np.any(k_h):
            self.k_h, self.exponent = self.k_h + k_h, exponent if self.exponent is None else self.exponent


def facing(n: float) -> float:
    """What a surface of an index reflects of what meets it straight on."""
    return ((n - 1) / (n + 1)) ** 2


def inner_share(n: float) -> float:
    """What a surface reflects of diffuse light that meets it from within, by a fit of d'Eon and Irving (2011)."""
    return -1.4399 / n**2 + 0.7099 / n + 0.6681 + 0.0636 * n
