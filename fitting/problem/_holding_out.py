"""Pixels that a fit does not look at, so that they can say how well it predicts: a shot, or blocks of each picture.

A pixel beside one that is fitted tells nothing new of a smooth surface: what is left out of a picture is left out in
whole blocks.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diffwhitted.scene import nearest_name

from .._errors import FitError
from ._target import CheckedTarget

BLOCK, FEWEST = 16, 20
"""Pixels along the side of a block; halved in a picture that would have fewer blocks."""
SEED = 1980

ALLOWED = "the name of a shot (or of the camera of a picture), or a share of the pixels, such as 0.2 or '20%'"


def held_out(
    targets: tuple[CheckedTarget, ...], hold_out: str | float | Sequence[str]
) -> tuple[tuple[CheckedTarget, ...], tuple[np.ndarray, ...], str]:
    """The targets with mask 0 where pixels are left out, these pixels (height, width) of each target, and in words what
    they are.

    `hold_out`: a name of a target, several, or a share of the pixels. Raises `FitError` for an unknown name, a share
    outside (0, 1), and where nothing is left to fit or nothing is left out.
    """
    share = _share(hold_out)
    if share is None:
        names = [hold_out] if isinstance(hold_out, str) else list(hold_out)  # pyright: ignore[reportArgumentType]
        known = [t.name for t in targets]
        for name in names:
            if name not in known:
                raise FitError(
                    f"hold_out: there is no shot {name!r}; there is {', '.join(known)}. Allowed is {ALLOWED}."
                    f"{nearest_name(name, known)}"
                )
        left_out = [t.mask > 0 if t.name in names else np.zeros(t.mask.shape, bool) for t in targets]
        what = f"shot{'s' * (len(names) > 1)} {', '.join(dict.fromkeys(names))}"
    else:
        random = np.random.default_rng(SEED)
        left_out = [_blocks(t.mask.shape, share, random) & (t.mask > 0) for t in targets]
        what = f"{100 * share:.3g} % of the pixels, in blocks"
    remaining = tuple(replace(t, mask=np.where(out, 0.0, t.mask)) for t, out in zip(targets, left_out, strict=True))
    if not any(t.mask.any() for t in remaining):
        raise FitError(f"hold_out = {hold_out!r}: it leaves no pixel to fit; hold out less")
    if not any(out.any() for out in left_out):
        raise FitError(f"hold_out = {hold_out!r}: it leaves out no pixel that counts; hold out more")
    return remaining, tuple(left_out), what


def _share(hold_out) -> float | None:
    """The share of the pixels; None for names."""
    if isinstance(hold_out, str):
        number, percent, rest = hold_out.strip().partition("%")
        try:
            share = float(number) / (100 if percent else 1)
        except ValueError:
            return None
        if rest:
            return None
    elif isinstance(hold_out, (int, float)) and not isinstance(hold_out, bool):
        share = float(hold_out)
    elif isinstance(hold_out, Sequence) and hold_out and all(isinstance(name, str) for name in hold_out):
        return None
    else:
        raise FitError(f"hold_out = {hold_out!r}; allowed is {ALLOWED}")
    if not 0 < share < 1:
        raise FitError(f"hold_out = {hold_out!r}; allowed is a share above 0 and below 1 (100%), or the name of a shot")
    return share


def _blocks(shape: tuple[int, ...], share: float, random: np.random.Generator) -> np.ndarray:
    """Whole blocks of a picture, as many as are nearest to that share of them, at least one."""
    side = BLOCK
    while side > 1 and np.prod([-(-length // side) for length in shape]) < FEWEST:
        side //= 2
    down, across = (-(-length // side) for length in shape)
    count = max(round(share * down * across), 1)
    chosen = np.zeros(down * across, bool)
    chosen[random.permutation(down * across)[:count]] = True
    whole = np.kron(chosen.reshape(down, across), np.ones((side, side), bool))
    return whole[: shape[0], : shape[1]]
