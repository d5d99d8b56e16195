"""Names that another program takes."""

import re
from collections.abc import Iterable


def words_of(names: Iterable[str], prefix: str = "", allowed: str = r"A-Za-z0-9_", longest: int = 40) -> dict[str, str]:
    """A word for each name, all different: what is not allowed becomes a line below, twins get a number."""
    words: dict[str, str] = {}
    for name in names:
        whole = prefix + (re.sub(rf"[^{allowed}]+", "_", name) or "_")
        word, number = whole[:longest], 2
        while word in words.values():
            word, number = f"{whole[: longest - 5]}_{number}", number + 1
        words[name] = word
    return words
