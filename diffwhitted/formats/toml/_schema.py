"""The scene file as models: which keys there are, and of what kind.

Keys are the names of the fields of the records in `diffwhitted.scene`, so that one pair of methods
reads and writes every entry: a new object, light or texture is one class here. The models check the
kind and length of what a file says; whether a value is allowed is for the records to say, and the
limits here serve the exported JSON Schema.
"""

import dataclasses
import math
from typing import Annotated, ClassVar, Literal, get_args

import numpy as np
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, create_model

from ..._errors import SceneError
from ...scene import (
    COEFFICIENTS,
    Camera,
    Checker,
    Coefficient,
    DirectionalLight,
    HighlightModel,
    Material,
    Plane,
    PointLight,
    Polygon,
    ShadowModel,
    Sphere,
    TotalReflection,
    shortest,
)


def _number(**limits):
    return Annotated[float, Field(allow_inf_nan=False, json_schema_extra=limits)]


def _list(item, shortest: int, longest: int | None = None):
    return Annotated[list[item], Field(min_length=shortest, max_length=longest)]


def _or_colour(number):
    """A number, or linear RGB; the kind of the value decides which of the two is checked."""
    return Annotated[
        Annotated[number, Tag("number")] | Annotated[_list(number, 3, 3), Tag("colour")],
        Discriminator(lambda value: "colour" if isinstance(value, list) else "number"),
    ]


def _optional(description: str):
    """A key that may be absent; TOML has no null, so the JSON Schema states no default."""
    return Field(None, description=description, json_schema_extra=lambda schema: schema.pop("default", None))


KEYS = ConfigDict(
    extra="forbid",
    strict=True,
    field_title_generator=lambda key, _: key,
    model_title_generator=lambda model: model.__name__.removesuffix("Entry").lower(),
)
Number = _number()
Vector = _list(Number, 3, 3)
Colour = _list(_number(minimum=0), 3, 3)
Name = Annotated[str, Field(min_length=1)]
Pixels = Annotated[int, Field(json_schema_extra={"minimum": 1, "maximum": 32768})]
ObjectName = Annotated[Name, Field(description="Name of the object, one of a kind.")]
MaterialName = Annotated[str, Field(description="Name of a material of this file.")]


def written(array):
    """Python numbers, as short as the precision of the array allows, that read back to the same bits."""
    array = np.asarray(array)
    if array.ndim:
        return [written(part) for part in array]
    number = array[()]
    short = shortest(number)
    return short if array.dtype.type(short) == number else float(number)


class Entry(BaseModel):
    """One table of the file; `made` is the record that it stands for."""

    model_config = KEYS
    made: ClassVar[type]

    def record(self, place: str, dtype):
        """The record, its arrays of `dtype`; raises `SceneError`, which begins with `place`."""
        fields = [field.name for field in dataclasses.fields(self.made) if field.name in type(self).model_fields]
        return self.made(
            place=place,
            **{field: self.value(field, place, dtype) for field in fields if getattr(self, field) is not None},
        )

    def value(self, field: str, place: str, dtype):
        """The value of a field: numbers as an array, text and counts as they are."""
        value = getattr(self, field)
        if not isinstance(value, (float, list)):
            return value
        with np.errstate(over="ignore"):
            array = np.asarray(value, dtype)
        if not np.isfinite(array).all():
            largest = np.ravel(value)[np.abs(value).argmax()]
            raise SceneError(
                f"{place}: {field} = {largest:g} is too large for {dtype.name}; allowed is up to "
                f"{np.finfo(dtype).max:.3g}. Write the scene in a larger unit, or read it as float64"
            )
        return array

    @classmethod
    def plain(cls, record, **stated) -> dict:
        """The table for a record, as Python numbers and text; `stated` are the keys that it does not hold."""
        if "type" in cls.model_fields:
            stated = {"type": get_args(cls.model_fields["type"].annotation)[0]} | stated
        held = {field: getattr(record, field, None) for field in cls.model_fields if field not in stated}
        values = stated | {
            field: value if isinstance(value, (str, int)) else written(value)
            for field, value in held.items()
            if value is not None
        }
        return {field: values[field] for field in cls.model_fields if field in values}


class GradientTable(Entry):
    """A background that changes with the height of the direction."""

    gradient: _list(Colour, 2, 2) = Field(description="Linear RGB straight down, then straight up.")


class SettingsEntry(Entry):
    """How light is treated, and what surrounds the scene."""

    background: Annotated[
        Annotated[Colour, Tag("colour")] | Annotated[GradientTable, Tag("gradient table")],
        Discriminator(lambda value: "gradient table" if isinstance(value, (dict, GradientTable)) else "colour"),
    ] = Field([0.0, 0.0, 0.0], description="Linear RGB, or { gradient = [bottom, top] }.")
    ambient: Colour = Field([1.0, 1.0, 1.0], description="Ambient light I_a, linear RGB; multiplies k_a.")
    max_depth: int = Field(
        5,
        json_schema_extra={"minimum": 1, "maximum": 64},
        description=(
            "Longest path from the camera; the camera ray is depth 1, a ray past the last depth returns black."
        ),
    )
    total_internal_reflection: TotalReflection = Field(
        "full", description=("full: all light goes to the mirror ray; whitted: T = 0 and k_s stays.")
    )
    shadows: ShadowModel = Field("opaque", description="tinted: each surface crossed multiplies the light by its k_t.")
    cutoff: _number(minimum=0, exclusiveMaximum=1) = Field(
        0, description=("A branch that would carry less than this in every channel is not followed; 0: all are.")
    )
    footprint: int = Field(
        0,
        json_schema_extra={"minimum": 0, "maximum": 64},
        description=("k: k x k trees a pixel, whose rays average what they meet over their share of it; 0: points."),
    )


class CameraEntry(Entry):
    """A pinhole camera."""

    made = Camera
    name: Name = Field("main", description="Name of the camera, one of a kind.")
    look_from: Vector = Field(description="Position of the pinhole, metres.")
    look_at: Vector = Field(description="A point in the middle of the picture, metres.")
    up: Vector = Field([0.0, 1.0, 0.0], description="Direction that is up in the picture.")
    vfov_deg: _number(exclusiveMinimum=0, exclusiveMaximum=180) = Field(
        description="Full vertical angle of view, degrees."
    )
    width: Pixels = Field(description="Columns of the picture.")
    height: Pixels = Field(description="Rows of the picture.")


class PointEntry(Entry):
    """A point that shines alike in all directions."""

    made = PointLight
    type: Literal["point"]
    position: Vector = Field(description="Where the light is, metres.")
    colour: Colour = Field(description="Linear RGB.")
    attenuation: _list(_number(minimum=0), 3, 3) = _optional(
        "a0, a1 (1/m), a2 (1/m^2): the colour is multiplied by min(1, 1 / (a0 + a1 d + a2 d^2)); no fade without it."
    )


class DirectionalEntry(Entry):
    """A light at infinity."""

    made = DirectionalLight
    type: Literal["directional"]
    direction: Vector = Field(description="Towards the light; any length but zero.")
    colour: Colour = Field(description="Linear RGB.")


class CheckerEntry(Entry):
    """The first colour where floor(x/s) + floor(y/s) + floor(z/s), over the listed axes, is even."""

    made = Checker
    name: Name = Field(description="Name of the texture, one of a kind.")
    type: Literal["checker"]
    colours: _list(Colour, 2, 2) = Field(description="Two linear RGB colours, even first.")
    size: _number(exclusiveMinimum=0) = Field(1.0, description="Edge s of a cell, metres.")
    axes: str = Field("xyz", description="The axes that are counted.", json_schema_extra={"pattern": "^[xyz]{1,3}$"})


def _coefficient(row: Coefficient):
    number = _number(minimum=row.lowest, **({"maximum": row.highest} if math.isfinite(row.highest) else {}))
    description = f"{row.symbol}: {row.meaning}; unit {row.unit}. {row.source}."
    field = _optional(description) if row.default is None else Field(row.default, description=description)
    return _or_colour(number) if row.coloured else number, field


MaterialEntry = create_model(
    "MaterialEntry",
    __base__=Entry,
    __doc__="What a surface is made of; a coefficient is a number or linear RGB.",
    name=(Name, Field(description="Name of the material, one of a kind.")),
    **{row.name: _coefficient(row) for row in COEFFICIENTS},
    highlight=(HighlightModel, Field("halfway", description="halfway: (N.H)^n; reflected: (V.R)^n; off: none.")),
    k_a_texture=(str, _optional("Name of a texture that multiplies k_a.")),
    k_d_texture=(str, _optional("Name of a texture that multiplies k_d.")),
)
MaterialEntry.made = Material


class SphereEntry(Entry):
    """A sphere."""

    made = Sphere
    name: ObjectName
    type: Literal["sphere"]
    centre: Vector = Field(description="Centre, metres.")
    radius: _number(exclusiveMinimum=0) = Field(description="Radius, metres.")
    material: MaterialName


class PlaneEntry(Entry):
    """The plane normal.x = offset; its inside is the side that the normal points away from."""

    made = Plane
    name: ObjectName
    type: Literal["plane"]
    normal: Vector = Field(description="Any length but zero.")
    offset: Number = Field(description="Metres, where the normal has unit length.")
    material: MaterialName


class PolygonEntry(Entry):
    """A plane polygon."""

    made = Polygon
    name: ObjectName
    type: Literal["polygon"]
    vertices: _list(Vector, 3) = Field(description="Metres, counter-clockwise seen from outside.")
    material: MaterialName


class TriangleEntry(Entry):
    """A triangle."""

    made = Polygon
    name: ObjectName
    type: Literal["triangle"]
    vertices: _list(Vector, 3, 3) = Field(description="Metres, counter-clockwise seen from outside.")
    material: MaterialName


class SceneFile(BaseModel):
    """A scene for diffwhitted. Right-handed, y up; metres, degrees, linear Rec. 709 RGB."""

    model_config = KEYS
    scene: SettingsEntry = Field(SettingsEntry(), description="Settings of the whole scene.")
    camera: list[CameraEntry] = Field([], description="Points of view.")
    light: list[Annotated[PointEntry | DirectionalEntry, Field(discriminator="type")]] = Field(
        [], description="Sources of light."
    )
    texture: list[CheckerEntry] = Field([], description="Patterns that multiply a coefficient.")
    material: list[MaterialEntry] = Field([], description="What objects are made of.")
    object: list[Annotated[SphereEntry | PlaneEntry | PolygonEntry | TriangleEntry, Field(discriminator="type")]] = (
        Field([], description="What is there.")
    )


def scene_schema() -> dict:
    """The JSON Schema (draft 2020-12) of a scene file, for editors and for programs that write scenes."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | SceneFile.model_json_schema()
