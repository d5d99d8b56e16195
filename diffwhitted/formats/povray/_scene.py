"""A whole scene as a file for POV-Ray 3.7 or newer."""

from ...scene import Scene
from .._format import Written
from .._losses import Losses, named
from .._numbers import index, main_camera, reflectances, rgb, text
from .._words import words_of
from ._materials import texture_of
from ._things import BACKGROUNDS, LIGHTS, SHAPES, camera
from ._words import colour

SAID = ("max_depth", "cutoff", "ambient", "shadows", "total_internal_reflection")
UNSEEN = "pigment { rgb 0 } finish { ambient 0 diffuse 0 } no_image no_reflection }"
"""What casts the whole shadow of something transparent, whose own is then left out."""


def povray_scene(scene: Scene, source: str) -> Written:
    """The scene; POV-Ray's picture of it is ours where nothing is lost."""
    del source
    lost = Losses("POV-Ray")
    lost.unknown_settings(scene, SAID)
    body = [*_settings(scene), *_cameras(scene, lost), *_background(scene, lost), *_lights(scene, lost)]
    words = words_of(scene.materials, "T_")
    worn = {thing.material for thing in scene.objects}
    for name in scene.materials:
        if name in worn:
            body += ["", f"#declare {words[name]} = // {named(name)}", texture_of(scene, name, lost)]
    body += ["", *_objects(scene, words, lost)]
    head = ["// Written by diffwhitted: linear colours, metres; z is turned round, as POV-Ray's axes are left-handed."]
    head += [f"// Not in this file: {sentence}" for sentence in lost.here()]
    return Written("\n".join([*head, *body, ""]).encode(), tuple(lost))


def _settings(scene: Scene) -> list[str]:
    ambient = rgb(scene.ambient)
    light = "" if (ambient == 1).all() else f" ambient_light {colour(ambient)}"
    return [
        "#version 3.7;",
        f"global_settings {{ assumed_gamma 1.0 max_trace_level {scene.max_depth} "
        f"adc_bailout {text(float(rgb(scene.cutoff)[0]))}{light} }}",
    ]


def _cameras(scene: Scene, lost: Losses) -> list[str]:
    """The main camera, and the others to be chosen by their number."""
    first = main_camera(scene)
    if first is None:
        lost.say("the scene has no camera, and so has the file")
        return []
    names = [first, *(name for name in scene.cameras if name != first)]
    for name in names:
        lost.unknown(scene.cameras[name], CAMERA, ("camera", name))
    view = scene.cameras[first]
    found = [f"// povray +I FILE +W{view.width} +H{view.height} -A +FE"]
    if len(names) == 1:
        return [*found, f"{camera(view)} // {named(first)}"]
    lost.say(
        f"one camera at a time: {named(first)} unless Declare=View=2 and so on asks for another; "
        f"in order: {', '.join(map(named, names))}"
    )
    found += ["#ifndef (View) #declare View = 1; #end", "#switch (View)"]
    for number, name in enumerate(names, 1):
        other = scene.cameras[name]
        found.append(f"#case ({number}) {camera(other)} // {named(name)}: +W{other.width} +H{other.height}\n#break")
    return [*found, "#end"]


CAMERA = ("look_from", "look_at", "up", "vfov_deg", "width", "height")


def _background(scene: Scene, lost: Losses) -> list[str]:
    kind = type(scene.background)
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
    for thing in scene.objects:
        what = ("object", thing.name)
        if type(thing) not in SHAPES:
            lost.say(f"left out: {{}} ({thing.written_type()})", what)
            continue
        lost.unknown(thing, [row.name for row in thing.ROWS], what)
        material = scene.materials[thing.material]
        clear, shape = bool(reflectances(material)["k_t"].any()), SHAPES[type(thing)](thing)
        solid = clear and type(thing).FAMILY.SOLID
        inside = f" interior {{ ior {text(index(material))} }}" if solid else ""
        hidden = clear and scene.shadows == "opaque"
        shadowless = " no_shadow" if hidden or scene.shadows == "off" else ""
        found.append(f"{shape} texture {{ {words[thing.material]} }}{inside}{shadowless} }} // {named(thing.name)}")
        if hidden:
            found.append(f"{shape} {UNSEEN} // its shadow")
        if solid and scene.total_internal_reflection == "whitted":
            lost.say('total_internal_reflection = "whitted": POV-Ray sends all light to the mirror ray, as "full" does')
    return found
