"""Numbers of a scene as other programs take them: float64 of the shortest digits, and their text."""

from collections.abc import Iterable

import numpy as np

from ..records import shortest
from ..scene import Material, PointLight, Scene, SpotLight

COLOURED = ("k_a", "k_d", "k_h", "k_s", "k_t")
KNOWN = (*COLOURED, "phong_exponent", "refractive_index")
"""The coefficients that the writers of other programs' files know; what is beyond them is told as lost."""
LARGEST_NUMBER = 1e30
"""Of a file of another program."""


def usable(word: str) -> float | None:
    """The number that a word of a file stands for; None of what is none, not finite, or above `LARGEST_NUMBER`."""
    try:
        number = float(word)
    except ValueError:
        return None
    return number if abs(number) <= LARGEST_NUMBER else None


def plain(value) -> np.ndarray:
    """The numbers with the fewest digits that read back as these in their own precision, float64."""
    value = np.asarray(value)
    return np.asarray([shortest(number) for number in value.ravel()], np.float64).reshape(value.shape)


def rgb(value) -> np.ndarray:
    """A number or a colour as three channels."""
    return plain(value) * np.ones(3)


def reflectances(material: Material) -> dict[str, np.ndarray]:
    """The coefficients that are colours, (3,) each; an absent k_h is k_s."""
    return {name: rgb(material.at_work(name)) for name in COLOURED}


def exponent(material: Material) -> float:
    return float(plain(material.phong_exponent))


def index(material: Material) -> float:
    return float(plain(material.refractive_index))


def text(number: float) -> str:
    """To twelve digits; no minus before a zero."""
    return f"{float(number) + 0.0:.12g}"


def listed(numbers: Iterable[float], between: str = " ") -> str:
    return between.join(map(text, numbers))


def extent(scene: Scene) -> tuple[np.ndarray, float]:
    """Middle (3,) and radius of a sphere around what has an end; of what the cameras look at, if nothing has."""
    balls = [thing.ball() for thing in scene.placed_objects()]
    balls = [(middle, radius) for middle, radius in balls if np.isfinite(radius)]
    if not balls:
        balls = [(plain(camera.look_at), 1.0) for camera in scene.cameras.values()] or [(np.zeros(3), 1.0)]
    low = np.min([middle - radius for middle, radius in balls], axis=0)
    high = np.max([middle + radius for middle, radius in balls], axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2


def halfway_exponent(material: Material) -> float:
    """The exponent of the halfway highlight nearest to the material's own: near its top (R.V)^n is (N.H)^(4 n)."""
    return exponent(material) * (4 if material.highlight == "reflected" else 1)


def fading(light: PointLight | SpotLight, distance: float) -> float:
    """What part of its colour arrives at a distance."""
    if light.attenuation is None:
        return 1.0
    total = float(plain(light.attenuation) @ (1.0, distance, distance**2))
    return (min(1.0, 1 / total) if light.held else 1 / total) if total else 1.0
