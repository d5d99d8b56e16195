"""Materials of Mitsuba as coefficients: the reverse of `_materials`, as far as there is one.

A blend (1 - w) A + w B adds what both send back. Fresnel's share of a smooth or rough surface is the one seen straight
on; a lobe of microfacets of the width alpha is a halfway highlight of the exponent n = 2 / alpha^2 - 2 with k_h =
F (n + 2) / 8 (see `_roughness`).
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..others._boards import Board
from ..others._found import Found, Paint
from ._boards import Corners, board_on
from ._sums import Sum, facing, inner_share
from ._tags import Tag
from ._values import GREY, shade, to_world

DEEPEST = 16
LEAST_ALPHA = 1e-3
GLASS = 1.5046
"""Of the interior where none is stated (bk7)."""
PLASTIC = 1.49
INDICES = {
    "vacuum": 1.0, "air": 1.000277, "water": 1.333, "ice": 1.31, "acetone": 1.36, "ethanol": 1.361, "bk7": 1.5046,
    "diamond": 2.419, "fused quartz": 1.458, "pyrex": 1.47, "acrylic glass": 1.49, "polypropylene": 1.49,
    "amber": 1.55, "pet": 1.575, "sodium chloride": 1.544,
}  # fmt: skip
METALS = {
    "none": (1.0, 1.0, 1.0), "Al": (0.912, 0.914, 0.920), "Ag": (0.972, 0.960, 0.915), "Au": (1.0, 0.766, 0.336),
    "Cu": (0.955, 0.638, 0.538), "Cr": (0.550, 0.556, 0.554), "W": (0.504, 0.498, 0.478),
}  # fmt: skip
"""Reflectance seen straight on, linear RGB."""


class Bsdfs:
    """The materials of a file by their identifiers, and the coefficients of those that shapes wear."""

    def __init__(self, root: Tag, found: Found):
        self._found, self._lost = found, found.lost
        self._known = {tag.attributes["id"]: tag for tag in root.of("bsdf", "texture") if "id" in tag.attributes}

    def worn(self, shape: Tag, corners: Corners | None, solid: bool) -> str:
        """The name of the material of a shape. `corners`: points and texture coordinates of one that is flat; `solid`:
        it bounds a volume.
        """
        stated = [tag for tag in shape.of("bsdf", "ref") if tag.name != "interior"]
        total, name = Sum(solid), None
        if stated:
            bsdf = self._of(stated[-1])
            name = (bsdf.attributes.get("id") or "").removeprefix("material_") or None
            self._add(bsdf, np.ones(3), total, 0)
        else:
            total.k_d = np.full(3, GREY)
        return self._found.material(self._paint(total, corners, name), name)

    def _paint(self, total: Sum, corners: Corners | None, name: str | None) -> Paint:
        boards: dict[str, Board] = {}
        for number, (tag, colours) in enumerate(total.boards):
            board = None if corners is None or number else board_on(colours, *corners, to_world(tag, "to_uv"))
            if board is None:
                self._lost.say("a checkerboard of {} is its mean colour", ("material", name or "without an id"))
                total.k_d = total.k_d + colours.mean(axis=0)
            else:
                boards["k_d"] = board
        if "k_d" in boards:
            # What is without a pattern is added to both colours.
            boards["k_d"] = boards["k_d"].painted(boards["k_d"].colours + total.k_d)
        fresnel = self._share_out(total)
        coefficients: dict[str, Any] = {"k_d": total.k_d, "k_s": total.k_s, "k_t": total.k_t, "k_h": total.k_h}
        coefficients |= {"phong_exponent": 50.0 if total.exponent is None else total.exponent}
        coefficients |= {"refractive_index": total.index}
        metal = total.metal and not boards and not any(map(np.any, (total.k_d, total.k_t)))
        if total.metal and not metal:
            self._lost.say("metals that are blended reflect at all angles what they do straight on")
        return Paint(coefficients, "reflected" if total.reflected else "halfway", boards, fresnel, metal)

    def _share_out(self, total: Sum) -> str:
        """Let Fresnel share out the light between the rays of glass, where no other mirror is; else its share straight
        on joins the mirror. Which model of Fresnel the material has.
        """
        if not total.glass:
            return "off"
        if len(total.glass) == 1 and not total.k_s.any():
            through, mirrored = total.glass[0]
            total.k_t, total.k_s = total.k_t + through, mirrored
            if (mirrored != 1).any():
                self._lost.say("the transmitted light of tinted glass is 1 - F k_s of k_t, in place of 1 - F")
            return "exact"
        share = facing(total.index)
        for through, mirrored in total.glass:
            total.k_t, total.k_s = total.k_t + through * (1 - share), total.k_s + mirrored * share
        self._lost.say("glass that is blended with a mirror reflects at all angles what it does straight on")
        return "off"

    def _of(self, tag: Tag) -> Tag:
        """What a reference stands for."""
        if tag.word != "ref":
            return tag
        identifier = tag.attributes.get("id", "")
        if identifier not in self._known:
            raise tag.error(f"<ref id={identifier[:40]!r}> names nothing; allowed is the id of a bsdf or a texture")
        return self._known[identifier]

    def _add(self, tag: Tag, weight: np.ndarray, total: Sum, depth: int) -> None:
        if depth > DEEPEST:
            raise tag.error(f"materials within materials more than {DEEPEST} deep; does one hold itself?")
        if tag.type in SAME:
            if SAME[tag.type]:
                self._lost.say(f"{SAME[tag.type]} is lost")
            inner = [self._of(child) for child in tag.of("bsdf", "ref")]
            for child in inner[:1]:
                self._add(child, weight, total, depth + 1)
            return
        if tag.type == "blendbsdf":
            share = shade(tag.named("weight"), 0.5, self._lost)
            for child, part in zip(
                [self._of(child) for child in tag.of("bsdf", "ref")], (1 - share, share), strict=False
            ):
                self._add(child, weight * part, total, depth + 1)
            return
        if tag.type not in MODELS:
            self._lost.say(f"a material ({tag.type[:40]}) is lost: it is grey")
            total.k_d = total.k_d + weight * GREY
            return
        MODELS[tag.type](self, tag, weight, total)

    def lost(self, sentence: str) -> None:
        self._lost.say(sentence)

    def colour(self, tag: Tag, name: str, default: float, weight: np.ndarray) -> np.ndarray:
        stated = tag.named(name)
        return weight * shade(None if stated is None else self._of(stated), default, self._lost)

    def diffuse(self, tag: Tag, name: str, weight: np.ndarray, total: Sum) -> None:
        """Diffuse light of a colour or a checkerboard."""
        stated = tag.named(name)
        stated = None if stated is None else self._of(stated)
        if stated is not None and stated.word == "texture" and stated.type == "checkerboard":
            pair = [shade(stated.named(f"color{k}"), usual, self._lost) for k, usual in ((0, 0.4), (1, 0.2))]
            total.boards.append((stated, np.stack(pair) * weight))
            return
        total.k_d = total.k_d + weight * shade(stated, GREY, self._lost)

    def ratio(self, tag: Tag, usual: float) -> float:
        """The index of the inside over that of the outside."""
        found = [usual, INDICES["air"] if tag.named("int_ior") is None else 1.0]
        for k, name in enumerate(("int_ior", "ext_ior")):
            word = tag.text(name, "")
            if word and word not in INDICES:
                raise tag.error(f"{name} = {word[:40]!r}; allowed is a number, or {', '.join(INDICES)}")
            found[k] = INDICES[word] if word else tag.number(name, found[k])
        if not found[1] > 0 or not found[0] > 0:
            raise tag.error(f"int_ior = {found[0]:g}, ext_ior = {found[1]:g}; allowed is more than 0")
        if found[0] < found[1]:
            self._lost.say("an index of the inside below that of the outside is taken for 1")
        return max(found[0] / found[1], 1.0)

    def metal(self, tag: Tag, weight: np.ndarray) -> np.ndarray:
        """What a metal reflects straight on."""
        tint = self.colour(tag, "specular_reflectance", 1.0, weight)
        if tag.named("eta") is not None:
            eta, k = (shade(tag.named(name), usual, self._lost) for name, usual in (("eta", 0.0), ("k", 1.0)))
            base = ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2)
        else:
            name = tag.text("material", "Cu")
            if name not in METALS:
                self._lost.say(f"the metal {name[:40]} is lost: it reflects all colours alike")
            base = np.asarray(METALS.get(name, (0.7,) * 3))
        return tint * base

    def lobe(self, tag: Tag, share: np.ndarray, total: Sum) -> None:
        """A highlight in place of microfacets of the reflectance `share`."""
        if tag.named("alpha_u") is not None:
            self._lost.say("the direction of brushed materials is lost")
        alpha = tag.number("alpha_u", tag.number("alpha", 0.1))
        if alpha <= 0:
            raise tag.error(f"alpha = {alpha:g}; allowed is more than 0")
        exponent = max(2 / max(alpha, LEAST_ALPHA) ** 2 - 2, 0.0)
        total.shine(share * (exponent + 2) / 8, exponent)
        self._lost.say("rough surfaces have highlights of lamps alone, and mirror nothing else")


def _diffuse(all_: Bsdfs, tag: Tag, weight: np.ndarray, total: Sum) -> None:
    all_.diffuse(tag, "reflectance", weight, total)


def _conductor(all_: Bsdfs, tag: Tag, weight: np.ndarray, total: Sum) -> None:
    total.k_s = total.k_s + all_.metal(tag, weight)
    total.metal = total.metal or tag.text("material", "Cu") != "none" or tag.named("eta") is not None


def _rough_conductor(all_: Bsdfs, tag: Tag, weight: np.ndarray, total: Sum) -> None:
    all_.lobe(tag, all_.metal(tag, weight), total)


def _dielectric(all_: Bsdfs, tag: Tag, weight: np.ndarray, total: Sum) -> None:
    """Bends light into a volume; of a sheet it goes straight on."""
    n = all_.ratio(tag, GLASS)
    through, mirrored = (all_.colour(tag, f"specular_{name}", 1.0, weight) for name in ("transmittance", "reflectance"))
    if tag.type == "roughdielectric":
        all_.lost("rough glass is clear")
    thin = tag.type == "thindielectric"
    if not thin and total.solid and n > 1:
        total.index = n
        total.glass.append((through, mirrored))
        return
    share = 2 * facing(n) / (1 + facing(n)) if thin else facing(n)
    total.k_t, total.k_s = total.k_t + through * (1 - share), total.k_s + mirrored * share
    if share:
        all_.lost("sheets of glass reflect at all angles what they do straight on, and do not bend light")


def _plastic(all_: Bsdfs, tag: Tag, weight: np.ndarray, total: Sum) -> None:
    """Diffuse light below a clear coat."""
    n = all_.ratio(tag, PLASTIC)
    part, base = Sum(total.solid), facing(n)
    all_.diffuse(tag, "diffuse_reflectance", np.ones(3), part)

    coloured = tag.truth("nonlinear", False)

    def below(colour: np.ndarray) -> np.ndarray:
        """What leaves the coat again; without `nonlinear` as if all of it came back white."""
        return (1 - base) ** 2 / n**2 * colour / (1 - inner_share(n) * (colour if coloured else 1.0))

    total.k_d = total.k_d + weight * below(part.k_d)
    total.boards += [(board, weight * below(colours)) for board, colours in part.boards]
    mirrored = all_.colour(tag, "specular_reflectance", 1.0, weight) * base
    if tag.type == "roughplastic":
        all_.lobe(tag, mirrored, total)
    else:
        total.k_s = total.k_s + mirrored
    all_.lost("the coat of plastic reflects at all angles what it does straight on")


def _phong(all_: Bsdfs, tag: Tag, weight: np.ndarray, total: Sum) -> None:
    """Its lobe is k (n + 2) / (2 pi) times a power of (V.R), and has N.L besides."""
    n = tag.number("exponent", 30.0)
    if n < 0:
        raise tag.error(f"exponent = {n:g}; allowed is >= 0")
    all_.diffuse(tag, "diffuse_reflectance", weight, total)
    total.shine(all_.colour(tag, "specular_reflectance", 0.2, weight) * (n + 2) / 2, n)
    total.reflected = True
    all_.lost("the highlight of a phong material has no factor N.L")


def _null(all_: Bsdfs, tag: Tag, weight: np.ndarray, total: Sum) -> None:
    total.k_t = total.k_t + weight


MODELS: dict[str, Callable[[Bsdfs, Tag, np.ndarray, Sum], None]] = {
    "diffuse": _diffuse,
    "conductor": _conductor,
    "roughconductor": _rough_conductor,
    "dielectric": _dielectric,
    "thindielectric": _dielectric,
    "roughdielectric": _dielectric,
    "plastic": _plastic,
    "roughplastic": _plastic,
    "phong": _phong,
    "null": _null,
}
"""Each adds its part to the sum, times a weight (3,)."""
SAME = {"twosided": "", "mask": "the opacity of a mask", "bumpmap": "a bump map", "normalmap": "a normal map"}
"""What is taken for the material in it, and what is then lost."""
