"""Materials of Mitsuba: a blend of what a material has of diffuse light, mirror, highlight and transmitted light.

Mitsuba adds no reflectances, but blends two materials by a weight w: (1 - w) A + w B. Each part is made as much
stronger as its share in the blend is small, so that k_d, k_s and k_t are what they are here while their sum is at
most 1.
"""

from collections.abc import Callable
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...scene import Checker, Material, Scene
from .._losses import Losses, Thing, named
from .._numbers import KNOWN, index, plain, reflectances
from .._roughness import facet_reflectance, width
from ._words import colour, number, word

Part = tuple[np.ndarray, Callable[[Element, np.ndarray], None]]
"""What a part sends back of light, (3,), and a function that adds it to an element with a reflectance."""
SMOOTHEST = 1e-3
"""alpha below which a highlight is written as a mirror's."""


def add_material(
    parent: Element, scene: Scene, name: str, identifier: str, flat: bool, solid: bool, lost: Losses
) -> None:
    """Add the material. `flat`: all that wears it has coordinates for its checkerboard; `solid`: all that wears it
    bounds a volume.
    """
    material, what = scene.materials[name], ("material", name)
    lost.unknown_coefficients(material, KNOWN, what)
    k, shine = reflectances(material), facet_reflectance(material)
    checker = _checker(scene, material, what, flat, lost)
    mean = np.ones(3) if checker is None else plain(checker.colours).mean(axis=0)
    pattern = checker if flat else None
    parts: list[Part] = []
    if k["k_d"].any():
        top = np.ones(3) if pattern is None else plain(pattern.colours).max(axis=0)
        parts.append((k["k_d"] * (mean if pattern is None else top), _diffuse(pattern)))
    if k["k_s"].any():
        parts.append((k["k_s"], _mirror))
    if shine.any():
        parts.append((shine, _highlight(max(width(material), SMOOTHEST))))
        lost.say(f"the highlight of {{}} is a lobe of microfacets, alpha = {width(material):.3g}", what)
    if k["k_t"].any():
        parts.append((k["k_t"], _clear(index(material), solid)))
        if solid and index(material) != 1:
            lost.say("the transmitted light of {} is k_t less Fresnel's part, which joins the mirror", what)
    if k["k_a"].any():
        lost.say("k_a of {} is lost", what)
    total = sum(float(value.max()) for value, _ in parts)
    if total > 1:
        lost.say(f"divided by {total:.3g}, as it sends back more than it gets: {{}}", what)
    _blend(parent, parts, 1 / max(total, 1.0), identifier)


def _checker(scene: Scene, material: Material, what: Thing, flat: bool, lost: Losses) -> Checker | None:
    """The checkerboard of k_d, and a sentence on every other texture."""
    found = None
    for coefficient, pattern in material.textures:
        texture = scene.textures[pattern]
        if coefficient != "k_d" or not isinstance(texture, Checker):
            lost.say(f"texture {named(pattern)} of {coefficient} of {{}} is lost", what)
            continue
        found = texture
        if not flat:
            lost.say(f"texture {named(pattern)} of {{}} is its mean colour, as not all that wears it is flat", what)
    return found


def _blend(parent: Element, parts: list[Part], scale: float, identifier: str | None = None, **names: str) -> None:
    """The parts, each times `scale`, as one material."""
    holder = {"id": identifier} if identifier else {}
    if len(parts) > 1:
        first, rest = float(parts[0][0].max()), sum(float(value.max()) for value, _ in parts[1:])
        weight = rest / (first + rest)
        blend = SubElement(parent, "bsdf", {"type": "blendbsdf", **holder, **names})
        number(blend, "weight", weight)
        _blend(blend, parts[:1], scale / (1 - weight), name="bsdf_0")
        _blend(blend, parts[1:], scale / weight, name="bsdf_1")
        return
    if not parts:
        parts = [(np.zeros(3), _diffuse(None))]
    value, add = parts[0]
    made = Element("holder")
    add(made, value * scale)
    inner = made[0]
    inner.attrib.update(holder | names)
    parent.append(inner)


def _two_sided(parent: Element, kind: str) -> Element:
    """Both sides of a surface are alike here."""
    return SubElement(SubElement(parent, "bsdf", type="twosided"), "bsdf", type=kind)


def _diffuse(checker: Checker | None) -> Callable[[Element, np.ndarray], None]:
    def add(parent: Element, value: np.ndarray) -> None:
        inner = _two_sided(parent, "diffuse")
        if checker is None:
            colour(inner, "reflectance", value)
            return
        two = plain(checker.colours)
        peak = two.max(axis=0)
        board = SubElement(inner, "texture", type="checkerboard", name="reflectance")
        for number_, shade in enumerate(two):
            colour(board, f"color{number_}", value * np.divide(shade, peak, out=np.zeros(3), where=peak > 0))

    return add


def _mirror(parent: Element, value: np.ndarray) -> None:
    inner = _two_sided(parent, "conductor")
    word(inner, "material", "none")
    colour(inner, "specular_reflectance", value)


def _highlight(alpha: float) -> Callable[[Element, np.ndarray], None]:
    def add(parent: Element, value: np.ndarray) -> None:
        inner = _two_sided(parent, "roughconductor")
        word(inner, "material", "none")
        word(inner, "distribution", "beckmann")
        number(inner, "alpha", alpha)
        colour(inner, "specular_reflectance", value)

    return add


def _clear(n: float, solid: bool) -> Callable[[Element, np.ndarray], None]:
    """What light goes through: straight on without a volume or at an index of 1; else bent, all of it mirrored where it
    cannot leave.
    """

    def add(parent: Element, value: np.ndarray) -> None:
        bends = solid and n != 1
        inner = SubElement(parent, "bsdf", type="dielectric" if bends else "thindielectric")
        number(inner, "int_ior", n if bends else 1.0)
        number(inner, "ext_ior", 1.0)
        colour(inner, "specular_transmittance", value)
        colour(inner, "specular_reflectance", value if bends else np.zeros(3))

    return add
