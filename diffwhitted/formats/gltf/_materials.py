"""Materials of glTF: metallic and roughness, and the extensions for index, transmission and specular colour.

glTF has one lobe that is mirror and highlight at once, of Fresnel reflectance F0 and width alpha = roughness^2. Here
F0 is k_s, or what gives the top of the highlight where there is no mirror; roughness = (2 / (n + 2))^(1/4) for an
exponent n of the halfway highlight (4 n of the reflected one). What has neither k_d nor k_t is metal of the colour k_s.
Diffuse light goes by (1 - t) C and transmitted by t C with the base colour C and the factor t: C = k_d + k_t.
"""

from typing import Any

import numpy as np

from ...scene import Material
from .._losses import Losses
from .._numbers import KNOWN, index, reflectances
from .._roughness import facet_reflectance, width

USUAL_INDEX = 1.5
"""glTF's, where a material states none."""
THICK = 1.0
"""Thickness that tells a viewer that the mesh is a solid, in units of the mesh."""


def material_of(name: str, material: Material, solid: bool, lost: Losses) -> tuple[dict[str, Any], np.ndarray]:
    """The material without textures, and its base colour, (3,). `solid`: all that is made of it bounds a volume."""
    what, k, n = ("material", name), reflectances(material), index(material)
    lost.unknown_coefficients(material, KNOWN, what)
    glass, mirror, extensions = bool(k["k_t"].any()), bool(k["k_s"].any()), {}
    metal = mirror and not glass and not k["k_d"].any()
    base = k["k_s"] if metal else k["k_d"] + k["k_t"]
    roughness = float(np.sqrt(width(material)))
    shine = facet_reflectance(material)
    # Diffuse and transmitted light.
    if glass:
        share = float(k["k_t"].sum() / base.sum())
        extensions["KHR_materials_transmission"] = {"transmissionFactor": share}
        if np.ptp([k["k_d"] * share - k["k_t"] * (1 - share)]) > 1e-6 * base.max():
            lost.say("k_d and k_t of {} have one hue in glTF, that of their sum", what)
        extensions["KHR_materials_ior"] = {"ior": n}
        if solid and n != 1:
            extensions["KHR_materials_volume"] = {"thicknessFactor": THICK}
    # Mirror and highlight.
    facets = k["k_s"] if mirror else shine
    if not metal:
        plain = (((n if glass else USUAL_INDEX) - 1) / ((n if glass else USUAL_INDEX) + 1)) ** 2
        if plain:
            factors = facets / plain
            extensions["KHR_materials_specular"] = {"specularColorFactor": factors.tolist()}
            if not facets.any():
                extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
        elif facets.any():
            lost.say("mirror and highlight of {}: glTF has none at an index of 1", what)
    if mirror:
        lost.say(f"the mirror of {{}} is blurred as the highlight is, by roughness {roughness:.3g}", what)
        if shine.any():
            lost.say("k_h of {} is lost: the highlight of glTF is as strong as the mirror, k_s", what)
    if k["k_a"].any():
        lost.say("k_a of {} is lost", what)
    if (base > 1).any():
        lost.say("the base colour of {} is limited to 1", what)
    made = {
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*np.clip(base, 0, 1).tolist(), 1.0],
            "metallicFactor": 1.0 if metal else 0.0,
            "roughnessFactor": roughness,
        },
        "doubleSided": "KHR_materials_volume" not in extensions,
    }
    return made | ({"extensions": extensions} if extensions else {}), base
