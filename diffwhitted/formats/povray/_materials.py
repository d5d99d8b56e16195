"""Materials as textures of POV-Ray.

A pigment P with the share t let through and a finish with `diffuse` d, `ambient` a send back d (1 - t) P of the diffuse
and a (1 - t) P of the ambient light. What needs a colour of its own (k_a beside k_d of another hue, a coloured k_t or
k_h) is a layer more: each upper layer lets half of what is below it through, which is made twice as strong.
"""

from collections.abc import Mapping

import numpy as np

from ...scene import Checker, Material, Scene
from .._losses import Losses, named
from .._numbers import KNOWN, exponent, listed, plain, reflectances, text
from ._words import amount, colour, grey

HALF = 0.5
"""What an upper layer lets through."""
LEAST = 1e-6
"""Filter of a channel without a highlight, whose light below is made so much stronger."""
FLATTEST = 1e6
"""The largest `roughness`, for an exponent of 0."""
ENDLESS = 1e6
"""Size of a cell along an axis that a checkerboard does not count, in cells."""

Frame = tuple[np.ndarray, np.ndarray]
"""Scale and shift of a pattern, (3,) each."""


def texture_of(scene: Scene, name: str, lost: Losses) -> str:
    """The texture, or its layers from the lowest up, or a checkerboard of them."""
    material, what = scene.materials[name], ("material", name)
    lost.unknown_coefficients(material, KNOWN, what)
    worn, checkers = {}, {}
    for coefficient, pattern in material.textures:
        texture = scene.textures[pattern]
        if isinstance(texture, Checker):
            worn[coefficient], checkers[pattern] = pattern, texture
        else:
            kind = texture.written_type()
            lost.say(f"texture {named(pattern)} ({kind}) of {coefficient} of {{}} is lost", what)
    frame = np.ones(3), np.zeros(3)
    return _patterned(checkers, material, reflectances(material), worn, frame)


def _patterned(
    checkers: Mapping[str, Checker], material: Material, k: Mapping, worn: Mapping[str, str], frame: Frame
) -> str:
    """A checkerboard of two textures for each checkerboard that the material wears, one within another."""
    if not worn:
        return "\n".join(layers(k, exponent(material), material.highlight))
    pattern = next(iter(worn.values()))
    checker = checkers[pattern]
    rest = {coefficient: other for coefficient, other in worn.items() if other != pattern}
    own = checker_frame(checker)
    parts = []
    for colours in plain(checker.colours):
        tinted = {key: value * colours if worn.get(key) == pattern else value for key, value in k.items()}
        parts.append(_patterned(checkers, material, tinted, rest, own))
    # What lies within a pattern is scaled and moved with it.
    scale, shift = own[0] / frame[0], (own[1] - frame[1]) / frame[0]
    both = ",\n".join(_indented(part) for part in parts)
    turned = f"scale <{listed(scale, ',')}> translate <{listed(shift, ',')}>"
    return f"texture {{ checker\n{both}\n  {turned}\n}}"


def _indented(part: str) -> str:
    """A texture inside another, layers and all."""
    return "\n".join(f"  {line}" for line in part.splitlines())


def checker_frame(checker: Checker) -> Frame:
    """In POV-Ray's axes, that of z turned back by a negative scale; an axis that is not counted lies in one cell."""
    size, corner = float(plain(checker.size)), plain(checker.corner) * (1, 1, -1)
    counted = np.asarray([axis in checker.axes for axis in "xyz"])
    scale = np.where(counted, size, size * ENDLESS) * (1, 1, -1)
    return scale, np.where(counted, corner, -scale / 2)


def layers(k: Mapping[str, np.ndarray], n: float, highlight: str) -> list[str]:
    """Textures from the lowest up, of coefficients (3,) each, the exponent and the model of the highlight."""
    k_h = np.zeros(3) if highlight == "off" else k["k_h"]
    coloured = not grey(k_h)
    coats = _coats(k["k_a"], k["k_d"])
    gloss = "" if coloured else _gloss(k_h[0], n, highlight)
    mirror = f" reflection {{ {colour(k['k_s'])} }}" if k["k_s"].any() else ""
    # One layer does where all of it goes by one pigment.
    through = k["k_t"][0]
    if not coloured and len(coats) == 1 and grey(k["k_t"]) and (through < 1 or not coats[0][0].any()):
        pigment, finish = coats[0]
        share = 1 - through if through < 1 else 1.0
        return [_layer(pigment / share, through, finish + gloss + mirror)]
    # Else each colour has its own; the lowest filters what comes through the surface.
    below = 2.0 ** len(coats)
    filters = np.maximum(k_h, LEAST) if coloured else np.ones(3)
    base = f"pigment {{ rgbf <{listed([*k['k_t'] * below / filters, 1], ',')}> }}" if k["k_t"].any() else ""
    shine = _gloss(below, n, highlight) if coloured else ""
    found = [f"texture {{ {base or 'pigment { rgb 0 }'} finish {{ ambient 0 diffuse 0{shine} }} }}"]
    if coloured:
        found.append(
            f"texture {{ pigment {{ rgbf <{listed([*filters, 1], ',')}> }} finish {{ ambient 0 diffuse 0 }} }}"
        )
    for number, (pigment, finish) in enumerate(coats):
        top = number == len(coats) - 1
        power = 2.0 ** (len(coats) - 1 - number)
        found.append(_layer(pigment * power / HALF, HALF, finish + (gloss + mirror) * top))
    return found


def _coats(k_a: np.ndarray, k_d: np.ndarray) -> list[tuple[np.ndarray, str]]:
    """Pigment and finish of the diffuse and the ambient light: one of both where their hues allow it."""
    if not k_d.any():
        return [(k_a, f"ambient {1 if k_a.any() else 0} diffuse 0")]
    if not k_a[k_d == 0].any():
        # A pigment of at most 1, so that the finish says how strong it is where it can.
        ratio = np.divide(k_a, k_d, out=np.zeros(3), where=k_d != 0)
        ratio = np.where(k_d == 0, ratio[k_d != 0][0], ratio)
        return [(k_d, f"ambient {amount(np.round(ratio, 12))} diffuse 1")]
    return [(k_d, "ambient 0 diffuse 1"), (k_a, "ambient 1 diffuse 0")]


def _layer(pigment: np.ndarray, through: float, finish: str) -> str:
    plain_colour = f"rgb <{listed(pigment, ',')}>"
    paint = f"rgbt <{listed([*pigment, through], ',')}>" if through else plain_colour
    return f"texture {{ pigment {{ {paint} }} finish {{ {finish} }} }}"


def _gloss(amount_: float, n: float, highlight: str) -> str:
    """(V.R)^n is `phong`, (N.H)^n is `specular` with the roughness 1 / n."""
    if not amount_:
        return ""
    if highlight == "reflected":
        return f" phong {text(amount_)} phong_size {text(n)}"
    return f" specular {text(amount_)} roughness {text(min(1 / n, FLATTEST) if n else FLATTEST)}"
