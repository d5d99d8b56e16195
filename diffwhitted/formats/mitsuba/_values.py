"""Colours and transforms in tags of Mitsuba."""

import numpy as np

from ...image import decode_signal
from .._losses import Losses
from ..others._placed import check, translated
from ._tags import Tag

GREY = 0.5


def shade(tag: Tag | None, default: float, lost: Losses) -> np.ndarray:
    """A colour (3,) of an element <rgb>, <spectrum>, <float> or <texture>."""
    if tag is None:
        return np.full(3, default)
    stated = tag.attributes.get("value", "")
    if tag.word in ("rgb", "srgb", "color") and stated.startswith("#"):
        return _by_codes(tag, stated)
    if tag.word in ("rgb", "srgb", "color", "float", "integer"):
        found = np.ones(3) * tag.numbers("value", 1, 3)
        return _checked(tag, np.asarray(decode_signal(found, "srgb")) if tag.word == "srgb" else found)
    if tag.word == "spectrum":
        if "value" in tag.attributes and ":" not in stated:
            return _checked(tag, np.ones(3) * tag.numbers("value", 1, 3))
        values = [pair.partition(":")[2] for pair in stated.replace(",", " ").split()]
        middle = Tag(tag.word, {"value": " ".join(values)}, tag.place)
        lost.say("spectra are their means: grey")
        return _checked(tag, np.full(3, np.mean(middle.numbers("value", len(values)) or [default])))
    lost.say(f"a texture ({tag.type or tag.word}) is lost: it is grey, {GREY:g}")
    return np.full(3, GREY)


def _by_codes(tag: Tag, stated: str) -> np.ndarray:
    try:
        codes = bytes.fromhex(stated[1:])
    except ValueError:
        codes = b""
    if len(codes) != 3:
        raise tag.error(f"value = {stated[:20]!r}; allowed is #rrggbb")
    return np.asarray(decode_signal(np.frombuffer(codes, np.uint8) / 255.0, "srgb"), np.float64)


def _checked(tag: Tag, found: np.ndarray) -> np.ndarray:
    if (found < 0).any():
        raise tag.error(f"value = {tag.attributes.get('value', '')[:40]!r} of <{tag.word}>; allowed is >= 0")
    return found


def to_world(tag: Tag, name: str = "to_world") -> np.ndarray:
    """The matrix (4, 4) of a transform, its first step done first."""
    stated, found = tag.named(name, "transform"), np.eye(4)
    for step in stated.children if stated else ():
        if step.word not in STEPS:
            raise step.error(f"<{step.word[:40]}> in a transform; allowed is {', '.join(STEPS)}")
        found = STEPS[step.word](step) @ found
    if stated:
        check(found, stated.place)
    return found


def _translate(step: Tag) -> np.ndarray:
    return translated(step.point())


def _scale(step: Tag) -> np.ndarray:
    if "value" in step.attributes:
        factors = np.ones(3) * step.numbers("value", 1, 3)
    else:
        factors = np.asarray([step.numbers(key, 1)[0] if key in step.attributes else 1.0 for key in "xyz"])
    return np.diag([*factors, 1.0])


def _rotate(step: Tag) -> np.ndarray:
    """About an axis by `angle` degrees (Rodrigues)."""
    axis, angle = step.point(), np.radians(step.numbers("angle", 1)[0])
    size = np.linalg.norm(axis)
    if not size > 0:
        raise step.error("<rotate> about an axis of no length; allowed is x, y, z with one other than 0")
    x, y, z = axis / size
    cross = np.asarray([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    found = np.eye(4)
    found[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return found


def _matrix(step: Tag) -> np.ndarray:
    numbers = np.asarray(step.numbers("value", 9, 16))
    found = np.eye(4)
    side = 3 if len(numbers) == 9 else 4
    found[:side, :side] = numbers.reshape(side, side)
    if (found[3] != (0, 0, 0, 1)).any():
        raise step.error("a matrix whose last row is not 0 0 0 1; allowed is one with that row")
    return found


def _look_at(step: Tag) -> np.ndarray:
    """z ahead, y up, x to the left."""
    origin, target = (np.asarray(step.numbers(key, 3)) for key in ("origin", "target"))
    up = np.asarray(step.numbers("up", 3)) if "up" in step.attributes else np.asarray([0.0, 1.0, 0.0])
    ahead = target - origin
    left = np.cross(up, ahead)
    if not (np.linalg.norm(ahead) > 0 and np.linalg.norm(left) > 0):
        raise step.error("<lookat> with the target at the origin, or up along the view; allowed is any other")
    ahead, left = ahead / np.linalg.norm(ahead), left / np.linalg.norm(left)
    found = np.eye(4)
    found[:3] = np.stack([left, np.cross(ahead, left), ahead, origin], axis=1)
    return found


STEPS = {"translate": _translate, "scale": _scale, "rotate": _rotate, "matrix": _matrix, "lookat": _look_at}
