"""Materials as Wavefront MTL has them, written only.

MTL's own model is Whitted's: Ka Ia + Kd sum (N.L) + Ks (sum (N.H)^Ns + mirror ray) + Tf transmitted ray, of which
`illum` says how much is at work. Ks is the highlight's coefficient and the mirror's at once.
"""

import numpy as np

from ..scene import Material, Scene
from ._format import SceneFormat, Written
from ._losses import Losses, Thing, named
from ._numbers import KNOWN, exponent, index, listed, reflectances, text
from ._words import words_of

LARGEST_EXPONENT = 1000


def mtl_materials(scene: Scene, source: str) -> Written:
    """The materials of a scene."""
    del source
    lost = Losses("MTL")
    lost.say("materials alone; objects, lights, cameras, background and ambient light are not in the file")
    lost.shots(scene)
    words = words_of(scene.materials, allowed=r"\w.-", longest=200)
    body = []
    for name, material in scene.materials.items():
        if words[name] != name:
            lost.say(f"material {named(name)} is called {words[name]}, as names have no spaces")
        body += ["", *_material(words[name], material, ("material", name), lost)]
    head = ["# Written by diffwhitted: linear RGB.", *(f"# Not in this file: {sentence}" for sentence in lost.here())]
    return Written("\n".join([*head, *body, ""]).encode(), tuple(lost))


def _material(word: str, material: Material, what: Thing, lost: Losses) -> list[str]:
    lost.unknown_coefficients(material, KNOWN, what)
    k, n = reflectances(material), exponent(material)
    k_h = np.zeros(3) if material.highlight == "off" else k["k_h"]
    glass, mirror, shine = bool(k["k_t"].any()), bool(k["k_s"].any()), bool(k_h.any())
    # Take the model with no more than the material has.
    illum = 6 if glass else 3 if mirror else 2 if shine else 1
    if (glass or mirror) and not np.array_equal(k["k_s"], k_h):
        lost.say(
            f"k_s of {{}} is lost: MTL mirrors by illum {illum} and the coefficient Ks, which is written as k_h", what
        )
    if shine and material.highlight == "reflected":
        lost.say('highlight = "reflected" of {}: MTL has the halfway highlight', what)
    if n > LARGEST_EXPONENT:
        lost.say(f"phong_exponent of {{}}: programs read Ns up to {LARGEST_EXPONENT}", what)
    for coefficient, texture in material.textures:
        lost.say(f"texture {named(texture)} of {coefficient} of {{}} is lost: MTL maps by uv alone", what)
    lines = [f"newmtl {word}"]
    lines += [f"{key} {listed(value)}" for key, value in (("Ka", k["k_a"]), ("Kd", k["k_d"]), ("Ks", k_h))]
    lines.append(f"Ns {text(n)}")
    if glass:
        lines += [f"Ni {text(index(material))}", f"d {text(max(0.0, 1 - k['k_t'].mean()))}", f"Tf {listed(k['k_t'])}"]
    return [*lines, f"illum {illum}"]


MTL = SceneFormat("MTL", (".mtl",), write=mtl_materials)
