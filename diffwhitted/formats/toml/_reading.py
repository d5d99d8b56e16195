"""Scenes as TOML files: reading, and writing so that reading gives back the same bits."""

import os
import re
import tomllib
import warnings
from collections.abc import Mapping
from pathlib import Path

import tomlkit
from pydantic import ValidationError

from ..._errors import SceneError, SceneNote
from ...records import Registry
from ...scene import BACKGROUNDS, CAMERAS, LIGHTS, OBJECTS, TEXTURES, Hemisphere, Precision, Scene, float_dtype
from ...scene.backgrounds import ConstantBackground, EnvironmentBackground, GradientBackground
from ..cameras import read_cameras
from ._entries import Entry, written
from ._faults import faults_of, ordinal, place, scene_error, shown
from ._radiosity import plain_radiosity
from ._schema import GradientTable, models
from ._shots import joined, relative
from ._textures import located, named_from
from ._unclosed import unclosed_array


def parse_scene(
    text: str, *, source: str = "scene", precision: Precision = "float32", folder: str | os.PathLike | None = None
) -> Scene:
    """The scene in a TOML text; `source` is what messages call it, `folder` where its pictures are. Raises
    `SceneError`.
    """
    document = _document(text, source)
    dtype = float_dtype(precision)
    try:
        file = models().file.model_validate(document)
    except ValidationError as error:
        raise scene_error(source, faults_of(error, document)) from None
    return _scene(file, dtype, source, None if folder is None else Path(folder))


def parse_bytes(data: bytes, source: str, precision: Precision) -> Scene:
    """The scene in the bytes of a TOML file. Raises `SceneError`."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError(
            f"{source}: line {line}: byte 0x{data[error.start]:02x} is not UTF-8; "
            "allowed is UTF-8 text. Save the file with that encoding"
        ) from None
    return parse_scene(text, source=source, precision=precision, folder=Path(source).parent)


def scene_text(scene: Scene, *, source: str = "scene", folder: Path | None = None) -> str:
    """A scene as TOML text whose files are named from `folder`, each number as short as its precision allows.

    Raises `SceneError` for what could not be read back, such as NaN or a value outside its interval.
    """
    tables = models()
    plain = {
        "scene": tables.settings.plain(
            scene,
            background=_plain_background(named_from(scene.background, folder)),
            ambient=_plain_ambient(scene.ambient),
            radiosity=plain_radiosity(scene.radiosity),
        ),
        "camera": [_plain_camera(name, camera) for name, camera in scene.cameras.items()],
        "light": [
            _plain(LIGHTS, tables.light, light, name=None if light.name == f"light_{number}" else light.name)
            for number, light in enumerate(scene.lights, 1)
        ],
        "texture": [
            _plain(TEXTURES, tables.texture, named_from(texture, folder), name=name)
            for name, texture in scene.textures.items()
        ],
        "material": [
            tables.material.plain(material, name=name, **dict.fromkeys(material.left_out()))
            for name, material in scene.materials.items()
        ],
        "object": [
            _plain(OBJECTS, tables.object, named_from(thing, folder), **dict.fromkeys(thing.left_out()))
            for thing in scene.objects
        ],
        "shot": [tables.shot.plain(relative(shot, folder)) for shot in scene.shots],
    }
    try:
        file = models().file.model_validate(plain)
    except ValidationError as error:
        raise scene_error(source, faults_of(error, plain)) from None
    with warnings.catch_warnings():
        # What there is to say of the scene was said when it was built.
        warnings.simplefilter("ignore", SceneNote)
        _scene(file, scene.dtype, source, folder, scene)
    return _dumped(plain)


def _document(text: str, source: str) -> dict:
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(_broken(str(error), text, source)) from None
    except RecursionError:
        raise SceneError(f"{source}: brackets are nested too deeply; allowed is two levels, as in vertices") from None
    except ValueError as error:
        reason = "a whole number has thousands of digits; allowed is up to 17" if "digits" in str(error) else str(error)
        raise SceneError(f"{source}: broken TOML: {reason}") from None
    if not document:
        raise SceneError(
            f"{source}: the file is empty; allowed are the tables [scene], [[camera]], [[light]], "
            "[[texture]], [[material]] and [[object]]. Start from an example"
        )
    return document


def _broken(message: str, text: str, source: str) -> str:
    at = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", message, re.DOTALL)
    lines = text.replace("\r\n", "\n").split("\n")
    began = unclosed_array(lines, int(at[2]) if at else len(lines) + 1)
    if began is not None:
        first = lines[began - 1].strip()
        comment = "; # begins a comment, so a colour is written as three numbers" if "#" in first else ""
        what = f"the array that begins here is not closed{comment}"
        return f"{source}: line {began}: broken TOML: {what}; the line is {shown(first)}"
    if not at:
        return f"{source}: broken TOML: {message}; something is not closed"
    what, line, column = at[1], int(at[2]), int(at[3])
    said = shown(lines[line - 1].strip()) if line <= len(lines) else ""
    return f"{source}: line {line}, column {column}: broken TOML: {what}; the line is {said}"


def _scene(file, dtype, source: str, folder: Path | None, known: Scene | None = None) -> Scene:
    """The scene of a file that was read; `known`: one whose pictures need not be read again."""
    faults = []

    def record(table: str, index: int, entry: Entry):
        if table == "texture" and known and getattr(entry, "file", None) is not None:
            return known.textures[entry.name]  # pyright: ignore[reportAttributeAccessIssue] a texture has a name
        return located(entry, folder).record(place(table, index, getattr(entry, "name", None)), dtype)

    def records(table: str) -> list:
        made = []
        for index, entry in enumerate(getattr(file, table)):
            try:
                made.append(record(table, index, entry))
            except SceneError as error:
                faults.append(str(error))
        return made

    def named(table: str) -> dict:
        return dict(zip((entry.name for entry in getattr(file, table)), records(table), strict=False))

    def measured() -> dict:
        """The cameras of another program, whose path is relative to the file."""
        if file.cameras is None:
            return {}
        try:
            found = read_cameras(Path(source).parent / file.cameras)
        except SceneError as error:
            faults.append(f"cameras = {shown(file.cameras)}: {error}")
            return {}
        for name in {entry.name for entry in file.camera} & set(found):
            faults.append(f"camera {shown(name)}: a [[camera]] and one of cameras have this name; rename it")
        return found

    for table in ("camera", "texture", "material", "object", "shot"):
        faults += _repeated(table, [entry.name for entry in getattr(file, table)])
    stated = dict(
        cameras=named("camera") | measured(),
        lights=records("light"),
        textures=named("texture"),
        materials=named("material"),
        objects=records("object"),
        shots=[joined(shot, folder) for shot in records("shot")],
    )
    try:
        settings = _settings(file.scene, dtype, folder, known)
        if not faults:
            return Scene(**stated, **settings, precision=dtype.name)
    except SceneError as error:
        faults.append(str(error))
    raise scene_error(source, faults)


def _repeated(table: str, names: list[str]) -> list[str]:
    where = {}
    for number, name in enumerate(names, 1):
        where.setdefault(name, []).append(ordinal(number))
    return [
        f"{table} {shown(name)}: the {' and the '.join(numbers[:2])} [[{table}]] have this name; "
        "allowed is one of a kind. Rename one"
        for name, numbers in where.items()
        if len(numbers) > 1
    ]


def _settings(settings: Entry, dtype, folder: Path | None, known: Scene | None) -> dict:
    rest = {key: settings.value(key, "scene", dtype) for key in type(settings).model_fields if key != "background"}
    if isinstance(settings.ambient, Entry):
        rest["ambient"] = settings.ambient.record("scene: ambient", dtype)
    if settings.radiosity is not None:
        rest["radiosity"] = settings.radiosity.as_read()
    return dict(background=_background(settings, dtype, folder, known), **rest)


def _background(settings: Entry, dtype, folder: Path | None, known: Scene | None):
    stated = settings.background
    if known is not None and isinstance(known.background, EnvironmentBackground):
        return known.background
    if isinstance(stated, GradientTable):
        return GradientBackground(*stated.value("gradient", "scene: background", dtype), place="scene")
    if isinstance(stated, Entry):
        return located(stated, folder).record("scene: background", dtype)
    return ConstantBackground(settings.value("background", "scene", dtype), place="scene")


def _plain_background(background):
    """As files have it: a colour, a gradient, or a table with the type."""
    match background:
        case ConstantBackground(colour=colour):
            return written(colour)
        case GradientBackground(bottom=bottom, top=top):
            return {"gradient": [written(bottom), written(top)]}
    return _plain(BACKGROUNDS, models().background, background)


def _plain_ambient(ambient):
    """As files have it: a colour, or a table of sky and ground."""
    if isinstance(ambient, Hemisphere):
        return {row.name: written(getattr(ambient, row.name)) for row in ambient.ROWS}
    return written(ambient)


def _plain_camera(name: str, camera) -> dict:
    """Without a type where it is the default, and with the picture as the file states it."""
    stated = {"type": None} if camera.written_type() == next(iter(CAMERAS)).TYPE else {}
    return _plain(CAMERAS, models().camera, camera, name=name, **stated, **camera.keys())


def _plain(registry: Registry, entries: Mapping[str, type[Entry]], record, **stated) -> dict:
    registry.check(record, "this cannot be written to a scene file")
    return entries[record.written_type()].plain(record, **stated)


def _dumped(plain: Mapping) -> str:
    document = tomlkit.document()
    for table, value in plain.items():
        if isinstance(value, list):
            entries = tomlkit.aot()
            for entry in value:
                entries.append(_table(entry))
            if entries:
                document.add(table, entries)
        else:
            document.add(table, _table(value))
    return tomlkit.dumps(document)


def _table(entry: Mapping):
    table = tomlkit.table()
    for key, value in entry.items():
        item = tomlkit.inline_table() if isinstance(value, dict) else tomlkit.item(value)
        if isinstance(value, dict):
            item.update(value)
        elif isinstance(value, list) and len(value) > 4:
            item.multiline(True)
        table.add(key, item)
    return table
