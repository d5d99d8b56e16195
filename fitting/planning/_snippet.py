"""Some tables of a scene file, to be pasted into one."""

from collections.abc import Collection

import tomlkit
from tomlkit.items import AoT

from diffwhitted.formats import scene_text
from diffwhitted.scene import Scene


def scene_tables(scene: Scene, wanted: Collection[tuple[str, str]]) -> str:
    """The tables of these, by family word and name, as TOML text."""
    found = tomlkit.document()
    for family, entries in tomlkit.parse(scene_text(scene)).items():
        if isinstance(entries, AoT):
            kept = tomlkit.aot()
            for entry in entries:
                if (family, entry.get("name")) in wanted:
                    kept.append(entry)
            if kept:
                found.add(family, kept)
    return tomlkit.dumps(found).strip() + "\n"
