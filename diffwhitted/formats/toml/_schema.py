"""The scene file as models: which keys there are, and of what kind.

Keys are the rows of the records in `diffwhitted.scene` and `diffwhitted.shapes`, kind by kind from their registries,
so that one pair of methods reads and writes every entry. The models check the kind and length of what a file says;
whether a value is allowed is for the records to say, and the limits here serve the exported JSON Schema.
"""

import functools
from difflib import get_close_matches
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Discriminator, Field, Tag, create_model

from ...records import Row
from ...scene import (
    BACKGROUNDS,
    CAMERAS,
    CLASS_NAMES,
    CLASSES,
    DISTANCE_FADE,
    LIGHTS,
    MOST_ROUGHNESS_SAMPLES,
    OBJECTS,
    RELIEFS,
    ROUGHNESS_SAMPLES,
    TEXTURES,
    FresnelModel,
    Hemisphere,
    HighlightModel,
    Material,
    ShadowModel,
    Shot,
    TotalReflection,
    coefficients,
    textured_rows,
)
from ._cameras import cameras, one_camera
from ._entries import Entry, MaterialEntry, ObjectEntry, entries, entry
from ._keys import KEYS, Colour, MaterialName, Name, ObjectName, key, listed, number, optional
from ._radiosity import RadiosityTable
from ._shots import ShotTable, shot_fields
from ._textures import BACKGROUND_TABLES, TABLES


class GradientTable(Entry):
    """A background that changes with the height of the direction."""

    gradient: listed(Colour, 2, 2) = Field(description="Linear RGB straight down, then straight up.")


class DispersionTable(Entry):
    """How a refractive index changes with the wavelength; one of these keys."""

    abbe: number() = optional("Abbe number V of a two-term Cauchy.", exclusiveMinimum=0)
    cauchy: listed(float, 2, 2) = optional("A and B of A + B / λ², λ in micrometres.")
    sellmeier: listed(listed(float, 1), 2, 2) = optional("B and C of Sellmeier's formula.")


def _dispersion():
    kinds = Annotated[str, Tag("name")] | Annotated[DispersionTable, Tag("abbe")]
    return Annotated[kinds, Discriminator(lambda value: "name" if isinstance(value, str) else "abbe")]


def _one_of(entries: dict[str, type[Entry]]):
    """One table of these, as its `type` says."""
    models = tuple(entries.values())
    return models[0] if len(models) == 1 else Annotated[functools.reduce(lambda a, b: a | b, models), _BY_TYPE]


_BY_TYPE = Field(discriminator="type")


def _background(tables: dict[str, type[Entry]]):
    """A colour, a table known by its key (a gradient, a map), or a table whose type names another background."""
    tables = tables | {"gradient": GradientTable}
    keyed = [name for name, table in tables.items() if "type" not in table.model_fields]

    def kind_of(value):
        if isinstance(value, Entry):
            return next(name for name, table in tables.items() if type(value) is table)
        if not isinstance(value, dict):
            return "colour"
        near = (get_close_matches(key, keyed, 1) for key in value if isinstance(key, str))
        return value.get("type") or next((found[0] for found in near if found), "gradient")

    kinds: Any = Annotated[Colour, Tag("colour")]
    for name, table in tables.items():
        kinds = kinds | Annotated[table, Tag(name)]
    return Annotated[kinds, Discriminator(kind_of)]


def _ambient():
    """A colour, or a table of sky and ground."""
    table = entry("ambient", Hemisphere, Hemisphere.ROWS)
    table = create_model("AmbientTable", __base__=table, __doc__=table.__doc__)
    kinds = Annotated[Colour, Tag("colour")] | Annotated[table, Tag("table")]
    return Annotated[kinds, Discriminator(lambda value: "table" if isinstance(value, (dict, Entry)) else "colour")]


class FileModels:
    """The models of all tables, for the kinds that are registered at the time."""

    def __init__(self):
        named = {"name": (ObjectName, ...), "material": (MaterialName, ...)}
        self.object = entries(OBJECTS, True, base=ObjectEntry, **named)
        self.light = entries(
            LIGHTS,
            True,
            beside=self.object,
            name=(str, optional("Name of the light, one of a kind; light_1, ... by default.")),
        )
        texture_name = (Name, Field(description="Name of the texture, one of a kind."))
        # Shots have a table called noise too.
        self.texture = entries(TEXTURES, False, bases=TABLES, beside={"noise": Entry}, name=texture_name)
        self.background = {
            name: entry(name, table.made, table.made.ROWS, base=BACKGROUND_TABLES.get(table.made, Entry))
            if table.made.KEYED
            else table
            for name, table in entries(BACKGROUNDS, False).items()
            if not table.made.SHORT
        }
        self.camera = cameras()
        self.material = entry(
            "material",
            Material,
            (),
            base=MaterialEntry,
            name=(Name, Field(description="Name of the material, one of a kind.")),
            **{"class": (Literal[CLASS_NAMES], Field(CLASS_NAMES[0], description=_classes()))},
            **{row.name: _coefficient(row) for row in coefficients()},
            highlight=(
                HighlightModel,
                Field("halfway", description="halfway: (N.H)^n; reflected: (V.R)^n; off: none."),
            ),
            fresnel=(
                FresnelModel,
                optional(
                    "How k_s and k_t change with the angle: exact (Fresnel), schlick, off; by default as the class "
                    "has it, off for whitted and exact for dielectric."
                ),
            ),
            dispersion=(
                _dispersion(),
                optional("How the index hangs on the wavelength: a table, or a substance's name."),
            ),
            roughness_samples=(
                int,
                Field(
                    ROUGHNESS_SAMPLES,
                    json_schema_extra={"minimum": 1, "maximum": MOST_ROUGHNESS_SAMPLES},
                    description=("Trees a pixel over which a rough surface is averaged, at the least."),
                ),
            ),
            fresnel_highlight=(bool, Field(False, description="The highlight is multiplied by that reflectance too.")),
            **{
                f"{row.name}_texture": (str, optional(f"Name of a texture that multiplies {row.name}."))
                for row in textured_rows()
            },
            **{key: (str, optional(meaning)) for key, meaning in RELIEFS.items()},
        )
        self.material.__doc__ = "What a surface is made of; a coefficient is a number or linear RGB."
        self.shot = entry("shot", Shot, Shot.ROWS, True, ShotTable, **shot_fields())
        self.settings = _settings(_background(self.background))
        self.file = self._file()

    def _file(self) -> type[BaseModel]:
        """The whole file."""
        tables = {
            "camera": (one_camera(self.camera), "Points of view."),
            "light": (_one_of(self.light), "Sources of light."),
            "texture": (_one_of(self.texture), "Patterns that multiply a coefficient."),
            "material": (self.material, "What objects are made of."),
            "object": (_one_of(self.object), "What is there."),
            "shot": (self.shot, "Pictures of the scene, for a fit."),
        }
        fields: dict[str, Any] = {
            "scene": (self.settings, Field(self.settings(), description="Settings of the whole scene."))
        }
        fields |= {name: (list[entry], Field([], description=text)) for name, (entry, text) in tables.items()}
        fields["cameras"] = (
            str,
            optional("Path from this file to cameras of another program: a folder of COLMAP, or a transforms.json."),
        )
        doc = "A scene for diffwhitted. Right-handed, y up; metres, degrees, linear Rec. 709 RGB."
        return create_model("SceneFile", __doc__=doc, __config__=KEYS, **fields)


def _classes() -> str:
    return "; ".join(f"{row.name}: {row.meaning}" for row in CLASSES) + "."


def _coefficient(row: Row):
    meaning = f"{row.symbol}: {row.meaning}; unit {row.unit}. {row.source}."
    annotation, _ = key(row)
    return annotation, optional(meaning) if row.default is None else Field(row.default, description=meaning)


def _settings(background) -> type[Entry]:
    """The table [scene]."""
    depth, trees = {"minimum": 1, "maximum": 64}, {"minimum": 0, "maximum": 64}
    return create_model(
        "SettingsEntry",
        __base__=Entry,
        __doc__="How light is treated, and what surrounds the scene.",
        background=(background, Field([0.0, 0.0, 0.0], description=(
            "Linear RGB, { gradient = [bottom, top] }, { environment = FILE } or { harmonics = [[r, g, b], ...] }."))),
        ambient=(_ambient(), Field([1.0, 1.0, 1.0], description=(
            "Ambient light I_a, linear RGB, or { sky, ground, up } by the way that a surface faces; multiplies k_a."))),
        distance_fade=(listed(number(), 2, 2), optional(DISTANCE_FADE.meaning)),
        radiosity=(RadiosityTable, optional(
            "Light between diffuse surfaces in place of the ambient light: { patches = 500 }.")),
        max_depth=(int, Field(5, json_schema_extra=depth, description=(
            "Longest path from the camera; the camera ray is depth 1, a ray past the last depth returns black."))),
        total_internal_reflection=(TotalReflection, Field("full", description=(
            "full: all light goes to the mirror ray; whitted: T = 0 and k_s stays."))),
        shadows=(ShadowModel, Field("opaque", description=(
            "tinted: each surface crossed multiplies the light by its k_t."))),
        cutoff=(number(minimum=0, exclusiveMaximum=1), Field(0, description=(
            "A branch that would carry less than this in every channel is not followed; 0: all are."))),
        bands=(int, Field(3, json_schema_extra={"minimum": 1, "maximum": 128}, description=(
            "Of the spectrum, where a material disperses light: 3 are red, green and blue; 1: no dispersion."))),
        seed=(int, Field(0, json_schema_extra={"minimum": 0}, description=(
            "Of what is left to chance, as rough surfaces: another one draws other samples."))),
        footprint=(int, Field(0, json_schema_extra=trees, description=(
            "k: k x k trees a pixel, whose rays average what they meet over their share of it; 0: points."))),
    )  # fmt: skip


_made: dict[tuple, FileModels] = {}


def models() -> FileModels:
    """The models for what is registered now; made once for each such set."""
    registered = (*OBJECTS, *LIGHTS, *TEXTURES, *BACKGROUNDS, *CAMERAS, *coefficients())
    if registered not in _made:
        _made.clear()
        _made[registered] = FileModels()
    return _made[registered]


def scene_schema() -> dict:
    """The JSON Schema (draft 2020-12) of a scene file, for editors and for programs that write scenes."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | models().file.model_json_schema()
