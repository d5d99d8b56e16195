"""The table of a camera."""

import functools
from typing import Annotated, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag

from ...scene import CAMERAS, VIEW
from ._entries import Entry, entries
from ._keys import Name, Pixels, Vector, listed, number, optional


class CameraTable(Entry):
    """A camera, of which a file says by a pose, or by two points, where it stands."""

    model_config = ConfigDict(
        json_schema_extra={"anyOf": [{"required": ["look_from", "look_at"]}, {"required": ["pose"]}]}
    )


def cameras() -> dict[str, type[Entry]]:
    """The models of cameras; the first kind is meant where no type is stated."""
    view = {row.name: row for row in VIEW}
    tables = entries(
        CAMERAS,
        False,
        next(iter(CAMERAS)).TYPE,
        base=CameraTable,
        name=(Name, Field("main", description="Name of the camera, one of a kind.")),
        width=(Pixels, Field(description="Columns of the full picture.")),
        height=(Pixels, Field(description="Rows of the full picture.")),
        look_from=(Vector, optional(f"{view['look_from'].meaning} Needed without a pose.")),
        look_at=(Vector, optional(f"{view['look_at'].meaning} Needed without a pose.")),
        up=(Vector, optional(view["up"].meaning, default=list(view["up"].default))),
        pose=(
            listed(listed(number(), 4, 4), 4, 4),
            optional("Camera to world, a matrix of 4 x 4 by rows, in place of look_from, look_at and up."),
        ),
        convention=(
            Literal["opengl", "opencv"],
            optional(
                "Axes of pose. opengl: x right, y up, z backwards (Blender); opencv: x right, y down, z ahead (COLMAP)",
                default="opengl",
            ),
        ),
        crop=(
            listed(int, 4, 4),
            optional("Left, top, width, height in pixels of the full picture: the picture is this window in it."),
        ),
    )
    for table in tables.values():
        table.made = table.made.from_keys
    return tables


def one_camera(tables: dict[str, type[Entry]]):
    """One table of these, as its `type` says, or the first of them."""
    default = next(iter(tables))

    def kind_of(value):
        stated = value.get("type", default) if isinstance(value, dict) else getattr(value, "type", default)
        return stated if isinstance(stated, str) else ""

    kinds = [Annotated[table, Tag(name)] for name, table in tables.items()]
    return Annotated[functools.reduce(lambda a, b: a | b, kinds), Discriminator(kind_of)]
