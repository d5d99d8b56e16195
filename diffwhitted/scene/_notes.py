"""What a person should know about a scene that is no error: given once, when the scene is built.

Only what is known is looked at; a scene whose values are traced has been looked at before.
"""

import warnings
from collections.abc import Iterator, Mapping, Sequence

import jax
import numpy as np

from .._errors import SceneNote
from ..records import is_traced, listed
from ..shapes import AbstractObject
from ._bodies import turned_faces
from ._coefficients import coefficients
from ._material import Material
from .backgrounds import AbstractBackground
from .cameras import AbstractCamera
from .lights import AbstractLight

MOST_SENT_BACK = 10.0
"""A share of light above this looks like a code from 0 to 255, or like percent."""
BRIGHTEST = 50.0
"""A colour above this, likewise."""
CODES = "codes from 0 to 255 are to be divided by 255 and decoded to linear light"
NARROWEST = 2.0
"""Degrees: an angle of view below this looks like radians."""


def give_notes(
    objects: Sequence[AbstractObject],
    materials: Mapping[str, Material],
    lights: Sequence[AbstractLight],
    cameras: Mapping[str, AbstractCamera],
    background: AbstractBackground,
) -> None:
    """Warn of what in a scene is likely not meant."""
    used = {thing.material for thing in objects}
    glass = {name for name, m in materials.items() if name in used and _is_glass(m)}
    with jax.ensure_compile_time_eval():
        notes = [
            *turned_faces(objects, glass),
            *_near_lamps(objects, lights),
            *_hard_outlines(objects, lights),
            *_lamps_inside(objects, glass, lights, cameras),
            *_large_shares(materials),
            *_bright_colours(lights, background),
            *_narrow_views(cameras),
        ]
    for note in notes:
        warnings.warn(note, SceneNote, stacklevel=5)


def _is_glass(material: Material) -> bool:
    k_t = material.values["k_t"]
    return is_traced(k_t) or bool(np.any(np.asarray(k_t) > 0))


def _known(record) -> bool:
    """Has each number of an object, a light or a camera a value?"""
    return not any(is_traced(getattr(record, row.name)) for row in record.ROWS)


def _near_lamps(objects: Sequence[AbstractObject], lights: Sequence[AbstractLight]) -> Iterator[str]:
    """Lamps so near to a surface that their fade is held at 1 there."""
    for light in lights:
        if not _known(light) or not (reach := light.held_within()) > 0:
            continue
        place = np.asarray(light.place(), np.float64)
        away = [(thing.away_from(place), thing.name) for thing in objects if _known(thing)]
        nearest, name = min(away, default=(np.inf, ""))
        if nearest < reach:
            yield (
                f"light {light.name!r} is {nearest:.3g} m from object {name!r}: nearer than {reach:.3g} m its "
                f"attenuation is held at 1, so it is no brighter there; for one that goes on to grow, as the inverse "
                "square does, write clamped = false beside it"
            )


def _hard_outlines(objects: Sequence[AbstractObject], lights: Sequence[AbstractLight]) -> Iterator[str]:
    """Objects whose shadow is hard though the light is a ball."""
    balls = [light.name or "" for light in lights if light.ball_radius() is not None]
    hard = list(dict.fromkeys(thing.written_type() for thing in objects if _is_hard(thing)))
    if balls and hard:
        yield (
            f"light {balls[0]!r} is looked at by one ray (samples = 0), and the outline of objects of type "
            f"{', '.join(hard)} is not known, so their shadows are hard; state samples = 16 or more to make them soft"
        )


def _is_hard(thing: AbstractObject) -> bool:
    """Does one ray to a ball of light see no outline of it that could hide a part?"""
    return not thing.FAMILY.FOOTPRINT or thing.FAMILY.SIDED


def _lamps_inside(
    objects: Sequence[AbstractObject],
    glass: set[str],
    lights: Sequence[AbstractLight],
    cameras: Mapping[str, AbstractCamera],
) -> Iterator[str]:
    """Lamps within what lets no light out, where no camera is."""
    if not cameras or not all(map(_known, cameras.values())):
        return
    solids = [thing for thing in objects if thing.solid]
    for light in lights:
        place = light.place() if _known(light) else None
        if place is None:
            continue
        for thing in (one for one in solids if _may_hold(one, place)):
            closed = thing.material not in glass and _known(thing) and thing.holds(place)
            if closed and not any(thing.holds(camera.look_from) for camera in cameras.values()):
                yield (
                    f"light {light.name!r} is inside object {thing.name!r}, which lets no light out (k_t = 0), and no "
                    "camera is in there; move one of the two"
                )
                break


def _may_hold(thing: AbstractObject, place: np.ndarray) -> bool:
    """A quick look, as scenes have thousands of balls."""
    if not type(thing).ROUND:
        return True
    try:
        middle, radius = type(thing).ball(thing)  # a bound method of an equinox module takes long to make
    except (jax.errors.TracerArrayConversionError, jax.errors.ConcretizationTypeError):
        return False
    return bool(abs(middle - place).max() <= radius)


def _large_shares(materials: Mapping[str, Material]) -> Iterator[str]:
    """Shares of light such as 200."""
    for name, material in materials.items():
        for row in coefficients():
            value = material.values[row.name]
            share = row.coloured and row.name != "emission"
            if share and value is not None and not is_traced(value) and np.max(value) > MOST_SENT_BACK:
                yield (
                    f"material {name!r}: {row.name} = {listed(value)} sends on more light than arrives; a share is "
                    f"mostly from 0 to 1, and {CODES}"
                )


def _bright_colours(lights: Sequence[AbstractLight], background: AbstractBackground) -> Iterator[str]:
    """Colours such as 255, but for lamps that fade, which need them."""
    things = [(f"light {light.name!r}", light) for light in lights if not light.fades]
    for place, record in (*things, ("scene: background", background)):
        for row in record.ROWS:
            value = getattr(record, row.name, None) if row.coloured else None
            if value is not None and not is_traced(value) and np.max(value) > BRIGHTEST:
                times = f"{np.max(value):.3g} times the white of a display"
                yield f"{place}: {row.name} = {listed(value)} is {times}; {CODES}"


def _narrow_views(cameras: Mapping[str, AbstractCamera]) -> Iterator[str]:
    """Angles of view such as 0.7."""
    for name, camera in cameras.items():
        stated = next((getattr(camera, row.name) for row in camera.ROWS if row.name == "vfov_deg"), None)
        if stated is not None and not is_traced(stated) and float(stated) < NARROWEST:
            angle = float(stated)
            yield (
                f"camera {name!r}: vfov_deg = {angle:.4g} is a very narrow view; it is in degrees, and {angle:.4g} "
                f"radians would be {np.degrees(angle):.4g}"
            )
