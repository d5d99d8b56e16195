"""The table [[shot]]: pictures of the scene, by the rows of `Shot` and the keys that are no numbers."""

import os
from pathlib import Path
from typing import Annotated, Any, ClassVar, get_args

from pydantic import Discriminator, Field, Tag

from ...records import changed
from ...scene import TEXTS, PixelFilter, Shot
from ._entries import Entry
from ._keys import KEYS, Name, listed, number, optional

FILES = ("picture", "mask")
"""The keys that name a file; `noise` may name one too."""


class NoiseEntry(Entry):
    """Variance = read^2 + gain * value, of linear values before the exposure is undone."""

    model_config = KEYS
    read: number(minimum=0) = Field(0.0, description="Standard deviation of a pixel without light.")
    gain: number(minimum=0) = Field(0.0, description="Variance for each unit of light.")


Noise = Annotated[
    Annotated[number(exclusiveMinimum=0), Tag("number")]
    | Annotated[NoiseEntry, Tag("model")]
    | Annotated[str, Tag("picture")],
    Discriminator(lambda v: "picture" if isinstance(v, str) else "model" if isinstance(v, (dict, Entry)) else "number"),
]


class ShotTable(Entry):
    """A picture of the scene: picture = exposure * radiance + black_level."""

    made: ClassVar[type] = Shot
    takes_name: ClassVar[bool] = True

    def value(self, field: str, place: str, dtype):
        match field:
            case "lights":
                return tuple(getattr(self, field))
            case "noise":
                noise = getattr(self, field)
                return {"read": noise.read, "gain": noise.gain} if isinstance(noise, NoiseEntry) else noise
        return super().value(field, place, dtype)

    @classmethod
    def plain(cls, record, **stated) -> dict:
        noise = record.noise
        own = {
            "lights": None if record.lights is None else list(record.lights),
            "noise": dict(zip(("read", "gain"), noise, strict=True)) if isinstance(noise, tuple) else noise,
        }
        return super().plain(record, **own, **stated)


def shot_fields() -> dict[str, Any]:
    """The keys that are no rows of numbers."""
    texts = {row.name: (str, optional(row.meaning)) for row in TEXTS}
    return {
        "name": (Name, Field(description="Name of the shot, one of a kind.")),
        **texts,
        "lights": (listed(Name, 1), optional("Names of the lights that burn. Default: all.")),
        "noise": (Noise, optional("Standard deviation; { read, gain }: variance = read^2 + gain * value; or a picture "
                                  "of standard deviations. Default: found from what the fit leaves over.")),
        "filter": (PixelFilter, optional(
            f"How a pixel averages: {', '.join(get_args(PixelFilter))}. Default: found out.")),
    }  # fmt: skip


def joined(shot: Shot, folder: Path | None) -> Shot:
    """The shot with its files relative to the working folder, in place of the one that holds the scene file."""

    def from_here(name: str | None) -> str | None:
        return name if name is None or folder is None else os.path.normpath(folder / name)

    noise = from_here(shot.noise) if isinstance(shot.noise, str) else shot.noise
    return changed(shot, noise=noise, **{key: from_here(getattr(shot, key)) for key in FILES})


def relative(shot: Shot, folder: Path | None) -> Shot:
    """The reverse: files as a scene file in that folder names them."""

    def from_there(name: str | None) -> str | None:
        return name if name is None or folder is None else Path(os.path.relpath(name, folder)).as_posix()

    noise = from_there(shot.noise) if isinstance(shot.noise, str) else shot.noise
    return changed(shot, noise=noise, **{key: from_there(getattr(shot, key)) for key in FILES})
