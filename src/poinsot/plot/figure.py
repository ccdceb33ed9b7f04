"""Figures whose vector files contain text as text."""

from __future__ import annotations

from os import fspath
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

__all__ = ["TextFigure"]

TEXT: dict[Any, Any] = {"svg.fonttype": "none", "pdf.fonttype": 42, "ps.fonttype": 42}
"""Options for text in SVG, and for fonts that can be searched and edited in PDF and PostScript."""

VECTOR = (".pdf", ".svg", ".ps", ".eps")

DOTS_PER_INCH = 200
"""Resolution of rasterised parts of a vector file: curves of very many points."""


class TextFigure(Figure):
    """Figure whose vector files contain text as text."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write the figure to a file, as `Figure.savefig` of matplotlib."""
        vector = not hasattr(fname, "write") and fspath(fname).lower().endswith(VECTOR)
        if vector or str(options.get("format", "")) in {suffix[1:] for suffix in VECTOR}:
            options.setdefault("dpi", DOTS_PER_INCH)
        with mpl.rc_context(TEXT):
            super().savefig(fname, **options)
