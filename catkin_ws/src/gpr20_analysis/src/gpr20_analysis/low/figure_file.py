"""Figures as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gpr20_analysis.errors import ExportError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")
RESOLUTION_DPI = 300


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, SVG or PDF, by the name's ending.

    Raises:
        ExportError: The name ends in something else.
        OSError: It cannot be written.
    """
    if path.suffix not in FORMATS:
        raise ExportError(f"{path.name} must end in {', '.join(FORMATS)}")
    figure.savefig(str(path), dpi=RESOLUTION_DPI)
