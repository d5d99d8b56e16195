"""What a surface is made of."""

from collections.abc import Callable, Mapping
from typing import Any, Literal, get_args

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from .._errors import SceneError
from ..records import is_traced, listed, nearest_name, number_array, require, whole_number
from ._classes import CLASS_BY_NAME, CLASS_NAMES, FRESNEL, MaterialClass
from ._coefficients import BY_NAME, SWITCHED, coefficients
from ._dispersion import Curve, read_dispersion, written_dispersion
from ._relief import RELIEFS, read_relief

HighlightModel = Literal["halfway", "reflected", "off"]
HIGHLIGHTS: tuple[str, ...] = get_args(HighlightModel)
FRESNEL_MODELS = (*FRESNEL, "metal")
"""What the weights of branches do with the angle: `fresnel`, and "metal" for Schlick's polynomial of a colour."""
ROUGHNESS_SAMPLES, MOST_ROUGHNESS_SAMPLES = 16, 4096
"""Trees a pixel of a rough surface, unless it states them, and at the most."""
TEXTURE = "_texture"
"""COEFFICIENT_texture names the texture that multiplies a coefficient."""


class Material(eqx.Module):
    """Coefficients of one material; each a number or, where the table allows it, linear RGB.

    Its coefficients are attributes (`material.k_d`), and so are the names of their textures (`material.k_d_texture`,
    None without one). A k_h that is None follows k_s, also through a derivative. The table of units, bounds and
    sources is `diffwhitted.COEFFICIENTS`. `class_` (in files `class`) is one of "whitted", "diffuse", "metal",
    "dielectric" and "polished" (Parker et al. 3.1); `fresnel` is "exact", "schlick" or "off", by default as the class
    has it; `fresnel_highlight` multiplies the highlight by the same reflectance. Raises `SceneError` for a value
    outside its interval and for a coefficient that the class does not have.
    """

    values: dict[str, Float[Array, ""] | Float[Array, "3"] | None]
    """By the names of the table."""
    highlight: HighlightModel = eqx.field(static=True)
    textures: tuple[tuple[str, str], ...] = eqx.field(static=True)
    """(coefficient, name of its texture), of those that have one."""
    class_: str = eqx.field(static=True)
    fresnel: str = eqx.field(static=True)
    fresnel_highlight: bool = eqx.field(static=True)
    curve: Curve | None = eqx.field(static=True)
    """The course of the index by wavelength, where it is that of a substance or of Sellmeier's formula."""
    roughness_samples: int = eqx.field(static=True)
    switched: tuple[str, ...] = eqx.field(static=True)
    """The coefficients of `SWITCHED` that it states."""
    relief: tuple[tuple[str, str], ...] = eqx.field(static=True)
    """(key, name of the texture) of what bends its normals: none, or one of `RELIEFS`."""

    def __init__(
        self,
        *,
        highlight: HighlightModel = "halfway",
        class_: str = CLASS_NAMES[0],
        fresnel: str | None = None,
        fresnel_highlight: bool = False,
        dispersion=None,
        roughness_samples: int = ROUGHNESS_SAMPLES,
        place: str = "material",
        **stated,
    ):
        self.class_ = _class(stated.pop("class", class_), place)
        relief = {key: stated.pop(key) for key in RELIEFS if key in stated}
        self.relief = read_relief(relief, stated.get("height_scale"), place)
        textures = {key: stated.pop(key) for key in list(stated) if key.endswith(TEXTURE) and key not in BY_NAME}
        unknown = sorted({*stated} - {*BY_NAME}) + sorted({*textures} - {row.name + TEXTURE for row in textured_rows()})
        if unknown:
            raise TypeError(f"{place}: unknown coefficient {unknown[0]!r}; there are {', '.join(BY_NAME)}")
        _check_stated(self.kind, [*stated, *textures], place)
        stated |= self._dispersed(dispersion, stated, place)
        self.roughness_samples = whole_number(
            roughness_samples, f"{place}: roughness_samples", highest=MOST_ROUGHNESS_SAMPLES
        )
        values = {name: stated.get(name, default) for name, default in _defaults(self.kind).items()}
        self.values = {name: None if value is None else checked(name, value, place) for name, value in values.items()}
        if highlight not in HIGHLIGHTS:
            raise SceneError(f"{place}: highlight = {highlight!r}; allowed is {', '.join(HIGHLIGHTS)}")
        self.highlight = highlight
        self.switched = tuple(name for name in SWITCHED if _stated(self.values[name]))
        self.fresnel = _fresnel(self.kind, fresnel, place)
        self.fresnel_highlight = _fresnel_highlight(self.kind, self.fresnel, fresnel_highlight, place)
        self.textures = tuple((key.removesuffix(TEXTURE), name) for key, name in textures.items() if name is not None)
        check_coat(self, place)

    def _dispersed(self, dispersion, stated, place: str) -> dict:
        """The coefficients that `dispersion` stands for, where they are not stated; sets the curve."""
        found, self.curve = read_dispersion(dispersion, place)
        beside = [name for name in found if name in stated and (name == "abbe_number" or self.curve is None)]
        if beside:
            raise SceneError(f"{place}: {beside[0]} is stated, and dispersion gives it too; leave one of them out")
        if dispersion is not None:
            _check_stated(self.kind, ["abbe_number"], place)
        return {name: value for name, value in found.items() if name not in stated}

    def __getattr__(self, name: str):
        values = object.__getattribute__(self, "__dict__").get("values", {})
        if name in values:
            return values[name]
        if name.endswith(TEXTURE) and name.removesuffix(TEXTURE) in values:
            return dict(self.textures).get(name.removesuffix(TEXTURE))
        if name == "class":
            return self.class_
        if name in RELIEFS:
            return dict(object.__getattribute__(self, "relief")).get(name)
        if name == "dispersion":
            return written_dispersion(self.curve)
        raise AttributeError(f"a material has no {name!r}; there are {', '.join(values)}")

    @property
    def kind(self) -> MaterialClass:
        """The row of its class."""
        return CLASS_BY_NAME[self.class_]

    @property
    def fresnel_model(self) -> str:
        """One of `FRESNEL_MODELS`."""
        return "metal" if self.class_ == "metal" and self.fresnel != "off" else self.fresnel

    def has(self, name: str) -> bool:
        """Does its class have the coefficient and, of one of `SWITCHED`, does it state it?"""
        return self.kind.stated(name) and (name not in SWITCHED or name in self.switched)

    @property
    def is_rough(self) -> bool:
        return "roughness" in self.switched

    @property
    def is_wrinkled(self) -> bool:
        """Are its normals bent?"""
        return bool(self.relief) and (self.relief[0][0] == "normal_texture" or "height_scale" in self.switched)

    def worn(self) -> tuple[tuple[str, str], ...]:
        """(key, name of the texture) of all textures that it names."""
        return (*((name + TEXTURE, texture) for name, texture in self.textures), *self.relief)

    def left_out(self) -> tuple[str, ...]:
        """The keys that a file need not state: what the class fixes, and what it says by default."""
        fixed = [row.name for row in coefficients() if not self.has(row.name)]
        defaults = {
            "roughness_samples": ROUGHNESS_SAMPLES,
            "dispersion": None,
            "class": CLASS_NAMES[0],
            "fresnel": self.kind.fresnel[0],
            "fresnel_highlight": False,
        }
        return (*fixed, *(key for key, value in defaults.items() if getattr(self, key) == value))

    @property
    def sources(self) -> Mapping[str, str]:
        """For each coefficient the one whose value works in its place, mostly itself: k_s for an absent k_h, k_d for
        the k_a of a polished one.
        """
        values, follows = self.values, self.kind.follows
        found = {name: follows.get(name, name) for name in values}
        return found | {"k_h": "k_s"} if values["k_h"] is None else found

    def texture_at_work(self, name: str) -> str | None:
        """The texture that multiplies a coefficient as light sees it."""
        return dict(self.textures).get(self.kind.follows.get(name, name))

    def highlight_coefficient(self):
        """k_h, or k_s where k_h is not given (Parker et al., after equation 1)."""
        return self.at_work("k_h")

    @property
    def is_shiny(self) -> bool:
        """Does it state a k_h of its own, and show it?"""
        return self.values["k_h"] is not None and self.highlight != "off"

    def at_work(self, name: str) -> Any:
        """The value of a coefficient as light sees it: an absent k_h is k_s."""
        return self.values[self.sources[name]]

    def all_at_work(self) -> dict[str, Any]:
        """The values of all coefficients as light sees them."""
        values = self.values
        return {name: values[source] for name, source in self.sources.items()}


CHOICES: Mapping[str, tuple[tuple, Callable[[Material], Any]]] = {
    "highlight": (HIGHLIGHTS, lambda m: m.highlight),
    "fresnel": (FRESNEL_MODELS, lambda m: m.fresnel_model),
    "fresnel_highlight": ((False, True), lambda m: m.fresnel_highlight),
    "polished": ((False, True), lambda m: m.class_ == "polished"),
}
"""What a material chooses beside its coefficients: the words that there are, and which one it has chosen."""


def _stated(value) -> bool:
    return is_traced(value) or bool(np.any(value != 0))


def textured_rows():
    """The coefficients that may have a texture: all that do not move rays, and belong to a surface."""
    return tuple(row for row in coefficients() if row.coloured and row.textured)


def checked(name: str, value, place: str) -> Any:
    """The value of a coefficient as an array, or `SceneError` naming the place and the interval."""
    row = BY_NAME[name]
    array = number_array(value, place, name, ((), (3,)) if row.coloured else ((),))
    require(row.holds, place, name, array, row.allowed(), row.advice(array))
    return array


def highest_coat(material: Material) -> float:
    """The largest k_d with which a polished material sends back no more light than it gets, at any angle:
    (1 - R0)**2; infinite of other classes, and of an index that is not known.
    """
    index: Any = material.values["refractive_index"]
    if material.class_ != "polished" or is_traced(index):
        return np.inf
    straight = ((float(index) - 1) / (float(index) + 1)) ** 2
    return (1 - straight) ** 2


def check_coat(material: Material, place: str) -> None:
    """Raise `SceneError` where a polished material sends back more light than it gets."""
    k_d: Any = material.values["k_d"]
    index: Any = material.values["refractive_index"]
    highest = highest_coat(material)
    if not is_traced(k_d) and np.max(k_d) > highest * (1 + 1e-6):
        raise SceneError(
            f"{place}: k_d = {listed(k_d)} of a polished material; allowed is at most (1 - R0)^2 = {highest:.4g} a "
            f"channel at refractive_index = {float(index):g}, so that no "
            "angle sends back more light than it gets"
        )


def _defaults(kind: MaterialClass) -> dict[str, Any]:
    """The value of each coefficient that is not stated; of what the class does not have, the one that does nothing."""
    absent = {row.name: kind.fixed.get(row.name, 0.0) for row in coefficients() if row.coloured}
    return {
        row.name: kind.defaults.get(row.name, row.default)
        if kind.stated(row.name)
        else absent.get(row.name, row.default)
        for row in coefficients()
    }


def _class(name, place: str) -> str:
    if name not in CLASS_NAMES:
        near = nearest_name(str(name), CLASS_NAMES)
        raise SceneError(f"{place}: class = {name!r}; allowed is {', '.join(CLASS_NAMES)}.{near}")
    return name


def _check_stated(kind: MaterialClass, keys: list[str], place: str) -> None:
    """Raise `SceneError` for a coefficient, or a texture of one, that the class does not have."""
    for key in keys:
        name = key.removesuffix(TEXTURE)
        if not kind.stated(name):
            raise SceneError(
                f"{place}: {key} is stated, and a material of class {kind.name!r} has none ({kind.meaning}); allowed "
                f'is {", ".join(kind.has or ())}. Leave it out, or write class = "whitted"'
            )


def _fresnel(kind: MaterialClass, stated: str | None, place: str) -> str:
    model = kind.fresnel[0] if stated is None else stated
    if model not in kind.fresnel:
        allowed = ", ".join(f'"{name}"' for name in kind.fresnel)
        raise SceneError(f"{place}: fresnel = {stated!r} of a material of class {kind.name!r}; allowed is {allowed}")
    return model


def _fresnel_highlight(kind: MaterialClass, fresnel: str, stated, place: str) -> bool:
    if not isinstance(stated, bool):
        raise SceneError(f"{place}: fresnel_highlight = {stated!r}; allowed is true or false")
    if stated and fresnel == "off":
        raise SceneError(
            f'{place}: fresnel_highlight = true, and fresnel = "off", by which it is multiplied; write '
            'fresnel = "exact" or "schlick", or leave it out'
        )
    return stated
