"""Drawings of matplotlib inside a page, in the inks of the page."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_VARIABLES = {"#010203": "var(--ink)", "#010204": "var(--muted)", "#010205": "var(--accent)"}
PAGE_INKS = tuple(_VARIABLES)
"""Colours to draw in that become the page's: ink, muted, accent."""


def page_svg(figure: Figure) -> str:
    """The figure as inline SVG."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    stream = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "diffwhitted"}):
        FigureCanvasSVG(figure).print_svg(stream, metadata={"Date": None})
    svg = stream.getvalue()
    # Inside a page the namespaces go without saying, and metadata would only name addresses.
    svg = re.sub(r"<metadata>.*?</metadata>| xmlns(:xlink)?=\"[^\"]*\"", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    for sentinel, variable in _VARIABLES.items():
        svg = svg.replace(sentinel, variable)
    return svg
