"""How numbers go from one keyframe of a film to the next."""

from enum import StrEnum


class Between(StrEnum):
    """`--between`."""

    linear = "linear"
    smooth = "smooth"
