"""Transforms as lists of steps."""

from collections.abc import Mapping

import numpy as np

from ..others._placed import translated, turned
from ._nodes import Entry

MOST_STEPS = 1000
DEEPEST = 32


def _shear(xy: float, xz: float, yx: float, yz: float, zx: float, zy: float) -> np.ndarray:
    return np.asarray([[1, xy, xz, 0], [yx, 1, yz, 0], [zx, zy, 1, 0], [0, 0, 0, 1]], float)


STEPS = {
    "translate": (3, lambda *by: translated(by)),
    "scale": (3, lambda x, y, z: np.diag([x, y, z, 1.0])),
    "rotate-x": (1, lambda angle: turned(0, angle)),
    "rotate-y": (1, lambda angle: turned(1, angle)),
    "rotate-z": (1, lambda angle: turned(2, angle)),
    "shear": (6, _shear),
}


def transform_of(entry: Entry, defined: Mapping[str, Entry]) -> np.ndarray:
    """The matrix (4, 4) of a list of steps, the first of which is done first; the name of a defined transform stands
    for its steps. Raises `SceneError` naming the line.
    """
    found, count = np.eye(4), 0
    ahead = [(one, 0) for one in reversed(entry.entries("transform") if entry.is_list else [entry])]
    while ahead:
        step, depth = ahead.pop()
        count += 1
        if count + len(ahead) > MOST_STEPS or depth > DEEPEST:
            raise entry.error(f"a transform of more than {MOST_STEPS} steps, or of itself; allowed is fewer")
        if not step.is_list:
            name = step.word("a step of a transform")
            if name not in defined:
                raise step.error(f"transform {name[:40]!r} is not defined above; allowed is {', '.join(STEPS)}")
            ahead += [(one, depth + 1) for one in reversed(defined[name].entries(name))]
            continue
        parts = step.entries("a step")
        if parts and parts[0].is_list:
            ahead += [(one, depth + 1) for one in reversed(parts)]
            continue
        word = parts[0].word("a step") if parts else ""
        if word in defined and len(parts) == 1:
            ahead.append((parts[0], depth + 1))
            continue
        if word not in STEPS:
            raise step.error(f"a step {word[:40]!r} of a transform; allowed is {', '.join(STEPS)}")
        size, make = STEPS[word]
        if len(parts) != size + 1:
            raise step.error(f"{word} has {len(parts) - 1} numbers; allowed is {size}")
        found = make(*(part.number(word) for part in parts[1:])) @ found
    return found
