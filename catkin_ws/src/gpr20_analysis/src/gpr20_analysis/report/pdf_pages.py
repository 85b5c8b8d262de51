"""A report as PDF: pages of text, then a page for each figure."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import List, Sequence, Tuple

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from gpr20_analysis.report.page import Section

A4_IN = (8.27, 11.69)
RESOLUTION_DPI = 200
LINES_ON_PAGE, LETTERS_IN_LINE = 68, 92
LETTERS_IN_CELL = 62
SIZE_PT, LEFT, TOP, LINE = 8, 0.08, 0.95, 0.0132

Line = Tuple[str, str, str]
"""Text, colour and weight."""


def write_pdf(path: Path, title: str, sections: Sequence[Section]) -> None:
    """Write a report.

    Raises:
        OSError: It cannot be written.
    """
    lines = _wrapped(title, "black", "bold")
    for section in sections:
        lines += [("", "black", "normal"), *_lines(section)]
    with PdfPages(str(path), metadata={"Title": title}) as pages:
        _write_text(pages, lines)
        for section in sections:
            for caption, figure in section.figures:
                text = f"{section.title}: {caption}"
                figure.text(0.01, 0.99, text, va="top", size=SIZE_PT, color="dimgrey")
                pages.savefig(figure, dpi=RESOLUTION_DPI)


def _lines(section: Section) -> List[Line]:
    found = [(section.title, "black", "bold")]
    for text in section.warnings:
        found += _wrapped(text, "darkred", "bold")
    for text in section.lines:
        found += _wrapped(text, "black", "normal")
    rows = [*([section.heading] if section.heading and section.rows else []), *section.rows]
    for row in _aligned(rows):
        found.append((row, "black", "normal"))
    return found


def _wrapped(text: str, colour: str, weight: str) -> List[Line]:
    return [(one, colour, weight) for one in textwrap.wrap(text, LETTERS_IN_LINE)]


def _aligned(rows: Sequence[Tuple[str, ...]]) -> List[str]:
    """Return the rows of a table with aligned columns; the last column is wrapped."""
    if not rows:
        return []
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]) - 1)]
    found = []
    for row in rows:
        parts = [textwrap.wrap(one, LETTERS_IN_CELL) for one in row[-1].splitlines()]
        last = [line for part in parts for line in part] or [""]
        head = "  ".join(text.ljust(width) for text, width in zip(row, widths))
        found.append(f"{head}  {last[0]}")
        found += [" " * (len(head) + 2) + more for more in last[1:]]
    return found


def _write_text(pages: PdfPages, lines: Sequence[Line]) -> None:
    for first in range(0, len(lines), LINES_ON_PAGE):
        sheet = Figure(figsize=A4_IN)
        for number, (text, colour, weight) in enumerate(lines[first : first + LINES_ON_PAGE]):
            # Escaped, because a dollar sign begins a formula.
            sheet.text(
                LEFT,
                TOP - number * LINE,
                text.replace("$", r"\$"),
                color=colour,
                weight=weight,
                size=SIZE_PT,
                family="monospace",
                va="top",
            )
        pages.savefig(sheet)
