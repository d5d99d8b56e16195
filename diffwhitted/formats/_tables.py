"""Tables for papers: LaTeX with booktabs, and Markdown; of the materials of a scene, written only."""

import re
from collections.abc import Callable, Sequence

import numpy as np

from .._errors import printable
from ..scene import Material, Scene, coefficients
from ._format import SceneFormat, Written
from ._losses import Losses, named
from ._numbers import plain

Table = Callable[[Sequence[str], Sequence[Sequence[str]], Sequence[str]], str]
"""Text of a table, from its head, its rows and the remarks on it. Symbols and numbers are between dollars, as LaTeX has
them; all else is plain text.
"""

_LATEX = {c: rf"\{c}" for c in "&%$#_{}"} | {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}",
    ">": r"\textgreater{}", "|": r"\textbar{}", '"': r"\textquotedbl{}",
}  # fmt: skip
_WORDS = {r"\pm": "±", r"\eta": "η", r"\times": "×", r"\ge": "≥", r"\le": "≤"}
_MATH = re.compile(r"(\$[^$]*\$)")
SAFE = "\N{FULLWIDTH DOLLAR SIGN}"
"""In place of a dollar in a name while the table is made."""


def latex_table(head: Sequence[str], rows: Sequence[Sequence[str]], remarks: Sequence[str]) -> str:
    """A `tabular` that needs the package booktabs; the remarks are comments before it."""

    def line(cells: Sequence[str]) -> str:
        return " & ".join(map(_latex, cells)) + r" \\"

    shape = "".join("r" if numeric else "l" for numeric in _numeric(rows, len(head)))
    return "\n".join([
        *(f"% {printable(remark)}".replace("\n", " ") for remark in remarks),
        rf"\begin{{tabular}}{{{shape}}}", r"  \toprule", f"  {line(head)}", r"  \midrule",
        *(f"  {line(row)}" for row in rows), r"  \bottomrule", r"\end{tabular}", "",
    ])  # fmt: skip


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]], remarks: Sequence[str]) -> str:
    """A table of pipes; the remarks follow it."""

    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(map(_markdown, cells)) + " |"

    ruler = "| " + " | ".join("---:" if numeric else "---" for numeric in _numeric(rows, len(head))) + " |"
    below = [f"- {_markdown(remark)}" for remark in remarks]
    return "\n".join([line(head), ruler, *map(line, rows), *([""] if below else []), *below, ""])


def _numeric(rows: Sequence[Sequence[str]], count: int) -> list[bool]:
    """Which columns hold formulas and numbers, and are set against their right."""
    return [bool(rows) and any(row[column].startswith("$") for row in rows) for column in range(count)]


def _latex(cell: str) -> str:
    parts = _MATH.split(printable(cell).replace("\n", " ").replace("\t", " "))
    written = [part if _MATH.fullmatch(part) else "".join(_LATEX.get(c, c) for c in part) for part in parts]
    return "".join(written).replace(SAFE, r"\$")


def _markdown(cell: str) -> str:
    def plain_math(found: re.Match[str]) -> str:
        text = re.sub(r"([_^])\{(-?\w+)\}", r"\1\2", found[1][1:-1])
        for word, sign in _WORDS.items():
            text = text.replace(word, sign)
        return text

    cell = _MATH.sub(plain_math, printable(cell).replace("\n", " ")).replace(SAFE, "$")
    return re.sub(r"([|`*<\\])", r"\\\1", cell)


def plain_words(name: str) -> str:
    """A name as a cell of a table: its dollars begin no formula."""
    return name.replace("$", SAFE)


def _symbol(symbol: str) -> str:
    letter, _, below = symbol.partition("_")
    return f"${_GREEK.get(letter, letter)}{f'_{{{below}}}' if below else ''}$"


_GREEK = {"η": r"\eta"}


def _of_materials(form_name: str, table: Table) -> Callable[[Scene, str], Written]:
    """A writer of a table of all materials of a scene, a line each."""

    def write(scene: Scene, source: str) -> Written:
        del source
        lost = Losses(form_name)
        lost.say("materials alone, to four digits; objects, lights, cameras and textures are not in the file")
        lost.shots(scene)
        columns = [(row, _symbol(row.symbol) if row.symbol else plain_words(row.name)) for row in coefficients()]
        head = ["material", *(symbol for _, symbol in columns), "highlight"]
        rows = [
            [plain_words(name), *(_cell(material, row.name, lost, name) for row, _ in columns), material.highlight]
            for name, material in scene.materials.items()
        ]
        for name, material in scene.materials.items():
            lost.unknown_choices(material, (), ("material", name))
        units = [f"{symbol} in {row.unit}" for row, symbol in columns if row.unit != "1"]
        means = [f"{symbol}: {row.meaning}" for row, symbol in columns]
        return Written(table(head, rows, [*means, *units, *map(plain_words, lost.here())]).encode(), tuple(lost))

    return write


def _cell(material: Material, coefficient: str, lost: Losses, name: str) -> str:
    value = plain(material.at_work(coefficient))
    if pattern := dict(material.textures).get(coefficient):
        lost.say(f"* {coefficient} is multiplied by texture {named(pattern)} in {{}}", ("material", name))
    marks = "*" if pattern else ""
    return ", ".join(f"${_four(number)}$" for number in np.ravel(value)) + marks


def _four(number: float) -> str:
    """To four digits, with a power of ten where that is shorter."""
    digits, _, power = f"{number:.4g}".partition("e")
    return rf"{digits} \times 10^{{{int(power)}}}" if power else digits


LATEX = SceneFormat("LaTeX", (".tex",), write=_of_materials("LaTeX", latex_table))
MARKDOWN = SceneFormat("Markdown", (".md",), write=_of_materials("Markdown", markdown_table))
