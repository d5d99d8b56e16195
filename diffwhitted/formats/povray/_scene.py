"""A whole scene as a file for POV-Ray 3.7 or newer."""

import os
from pathlib import Path

from ...scene import EnvironmentBackground, HarmonicBackground, Hemisphere, Scene
from .._format import Written
from .._losses import Losses, named
from .._numbers import index, reflectances, rgb, text
from .._panoramas import ENDING, exr_file, panorama
from .._views import views_of
from .._words import words_of
from ._materials import texture_of
from ._things import BACKGROUNDS, CAMERAS, LIGHTS, SHAPES, sky_map
from ._words import colour

SAID = ("max_depth", "cutoff", "ambient", "shadows", "total_internal_reflection")
UNSEEN = "pigment { rgb 0 } finish { ambient 0 diffuse 0 } no_image no_reflection }"
"""What casts the whole shadow of something transparent, whose own is then left out."""


def povray_scene(scene: Scene, source: str) -> Written:
    """The scene; POV-Ray's picture of it is ours where nothing is lost."""
    lost = Losses("POV-Ray")
    lost.unknown_settings(scene, SAID)
    stem, beside = Path(os.path.realpath(source)).stem, {}
    sky = _background(scene, f"{stem}{ENDING}", beside, lost)
    body = [*_settings(scene, lost), *_cameras(scene, lost), *sky, *_lights(scene, lost)]
    words = words_of(scene.materials, "T_")
    worn = {thing.material for thing in scene.objects}
    for name in scene.materials:
        if name in worn:
            body += ["", f"#declare {words[name]} = // {named(name)}", texture_of(scene, name, lost)]
    body += ["", *_objects(scene, words, lost)]
    head = ["// Written by diffwhitted: linear colours, metres; z is turned round, as POV-Ray's axes are left-handed."]
    head += [f"// Not in this file: {sentence}" for sentence in lost.here()]
    return Written("\n".join([*head, *body, ""]).encode(), tuple(lost), beside)


def _settings(scene: Scene, lost: Losses) -> list[str]:
    ambient = scene.ambient
    if isinstance(ambient, Hemisphere):
        lost.say("ambient light is the mean of sky and ground, alike from all sides")
        ambient = ambient.even()
    ambient = rgb(ambient)
    light = "" if (ambient == 1).all() else f" ambient_light {colour(ambient)}"
    return [
        "#version 3.7;",
        f"global_settings {{ assumed_gamma 1.0 max_trace_level {scene.max_depth} "
        f"adc_bailout {text(float(rgb(scene.cutoff)[0]))}{light} }}",
    ]


def _cameras(scene: Scene, lost: Losses) -> list[str]:
    """The main camera, and the others to be chosen by their number."""
    views = views_of(scene, CAMERAS, lost)
    if not scene.cameras:
        lost.say("the scene has no camera, and so has the file")
    written = [f"{CAMERAS[type(view)](view)} // {named(name)}" for name, view in views.items()]
    sizes = [f"+W{view.width} +H{view.height}" for view in views.values()]
    found = [f"// povray +I FILE {size} -A +FE" for size in sizes[:1]]
    if len(views) < 2:
        return found + written
    first, *_ = order = list(map(named, views))
    lost.say(
        f"one camera at a time: {first} unless Declare=View=2 and so on asks for another; in order: {', '.join(order)}"
    )
    found += ["#ifndef (View) #declare View = 1; #end", "#switch (View)"]
    for number, (camera, size) in enumerate(zip(written, sizes, strict=True), 1):
        found.append(f"#case ({number}) {camera}: {size}\n#break")
    return [*found, "#end"]


def _background(scene: Scene, file: str, beside: dict[str, bytes], lost: Losses) -> list[str]:
    """What surrounds the scene; a map goes into a file beside it."""
    kind = type(scene.background)
    if isinstance(scene.background, (EnvironmentBackground, HarmonicBackground)):
        texels, turned = panorama(scene.background, lost)
        beside[ENDING] = exr_file(texels)
        lost.say(f"the map of the background is in {file} beside it; povray +L FOLDER says where that is")
        if scene.background.lights:
            lost.say("the background lights no surface in POV-Ray")
        return [sky_map(file, turned)]
    if kind not in BACKGROUNDS:
        lost.say(f"the background ({scene.background.written_type()}) is left out: it is black in the file")
        return []
    return [BACKGROUNDS[kind](scene.background)]


def _lights(scene: Scene, lost: Losses) -> list[str]:
    found = []
    for light in scene.lights:
        if type(light) not in LIGHTS:
            lost.say(f"left out: {{}} ({light.written_type()})", ("light", light.name or ""))
            continue
        lost.unknown(light, [row.name for row in light.ROWS], ("light", light.name or ""))
        found.append(f"{LIGHTS[type(light)](light, scene, lost)} // {named(light.name or '')}")
    return found


def _objects(scene: Scene, words: dict[str, str], lost: Losses) -> list[str]:
    found = []
    for thing in scene.placed_objects():
        what = ("object", thing.name)
        if type(thing) not in SHAPES:
            lost.say(f"left out: {{}} ({thing.written_type()})", what)
            continue
        lost.unknown(thing, [row.name for row in thing.ROWS], what)
        material = scene.materials[thing.material]
        clear, shape = bool(reflectances(material)["k_t"].any()), SHAPES[type(thing)](thing)
        solid = clear and thing.solid
        inside = f" interior {{ ior {text(index(material))} }}" if solid else ""
        hidden = clear and scene.shadows == "opaque"
        shadowless = " no_shadow" if hidden or scene.shadows == "off" else ""
        found.append(f"{shape} texture {{ {words[thing.material]} }}{inside}{shadowless} }} // {named(thing.name)}")
        if hidden:
            found.append(f"{shape} {UNSEEN} // its shadow")
        if solid and scene.total_internal_reflection == "whitted":
            lost.say('total_internal_reflection = "whitted": POV-Ray sends all light to the mirror ray, as "full" does')
    return found
