"""The texts and tables of a report as lines of pages, by the widths of their letters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Sequence, Tuple

from gpr20_analysis.plotting.noted_figure import PART_OF_WIDTH, POINTS_PER_IN, width_pt, wrapped
from gpr20_analysis.report.records import Report, Section

PAGE_PT = (595.0, 842.0)
"""A4."""
LEFT_PT, TOP_PT, BOTTOM_PT = 48.0, 56.0, 64.0
TEXT_WIDTH_PT = PAGE_PT[0] - 2.0 * LEFT_PT
TITLE_PT, HEADING_PT, TEXT_PT, SMALL_PT = 14.0, 10.5, 8.0, 7.0
LINE_SPACING, BETWEEN_COLUMNS_PT, NARROWEST_PT = 1.4, 12.0, 36.0
# A longer row may continue on the next page.
MOST_TOGETHER = 10
# Bold letters are wider than those that are measured.
BOLD_PART = 0.85


@dataclass(frozen=True)
class Line:
    """One line of a page.

    Attributes:
        cells: Distance from the left margin [points], and text.
        size_pt: Size of the letters [points].
        colour: Colour of the letters.
        weight: "normal" or "bold".
        titles: Titles of the table that it is part of; a page that begins with it repeats them.
        row_lines: Number of lines from this one on that stay together.
    """

    cells: Tuple[Tuple[float, str], ...]
    size_pt: float = TEXT_PT
    colour: str = "black"
    weight: str = "normal"
    titles: Tuple[Line, ...] = ()
    row_lines: int = 1

    @property
    def height_pt(self) -> float:
        """Height of the line [points]."""
        return self.size_pt * LINE_SPACING


def text_pages(report: Report) -> List[List[Line]]:
    """Return the lines of each page of text."""
    lines = _text(report.title, TITLE_PT, weight="bold")
    for section in report.sections:
        lines += [Line((), HEADING_PT), *_section(section)]
    pages: List[List[Line]] = [[]]
    left_pt = full_pt = PAGE_PT[1] - TOP_PT - BOTTOM_PT
    for line in lines:
        # A heading is not the last line of a page.
        needed_pt = line.height_pt * (3.0 if line.size_pt == HEADING_PT else line.row_lines)
        if needed_pt > left_pt and left_pt < full_pt:
            pages.append(list(line.titles))
            left_pt = full_pt - sum(title.height_pt for title in line.titles)
        if line.cells or pages[-1]:
            pages[-1].append(line)
            left_pt -= line.height_pt
    return pages


def _section(section: Section) -> List[Line]:
    lines = _text(section.title, HEADING_PT, weight="bold")
    if section.notice:
        lines += _text(section.notice, colour="firebrick", weight="bold")
    for text in section.warnings:
        lines += _text(text, colour="darkred", weight="bold")
    for text in section.lines:
        lines += _text(text)
    return [*lines, *_table(section)]


def _text(
    text: str, size_pt: float = TEXT_PT, colour: str = "black", weight: str = "normal"
) -> List[Line]:
    usable_pt = TEXT_WIDTH_PT * (BOLD_PART if weight == "bold" else 1.0)
    found = wrapped([text], usable_pt / POINTS_PER_IN, size_pt)
    return [Line(((0.0, one),), size_pt, colour, weight) for one in found]


def _table(section: Section) -> List[Line]:
    rows = [*([section.heading] if section.heading and section.rows else []), *section.rows]
    if not rows:
        return []
    widths_pt = _column_widths(section.heading, section.rows)
    titles: List[Line] = []
    lines: List[Line] = []
    for row in rows:
        is_heading = row is section.heading
        cells = [
            wrapped([cell], column_pt / POINTS_PER_IN, TEXT_PT)
            for cell, column_pt in zip(row, widths_pt)
        ]
        height = max(len(one) for one in cells)
        for number in range(height):
            right_pt, parts = 0.0, []
            for one, column_pt in zip(cells, widths_pt):
                if number < len(one):
                    parts.append((right_pt, one[number]))
                right_pt += column_pt + BETWEEN_COLUMNS_PT
            if is_heading:
                together = height - number + 1
                titles.append(Line(tuple(parts), colour="dimgrey", row_lines=together))
            else:
                row_lines = 1 if number else min(height, MOST_TOGETHER)
                lines.append(Line(tuple(parts), titles=tuple(titles), row_lines=row_lines))
    return [*titles, *lines]


def _column_widths(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> List[float]:
    """Return widths of columns that fit beside each other; the widest are narrowed first."""
    widths_pt = [max(_width_pt(cell) for cell in column) for column in zip(*rows)]
    # A title is divided between words, rather than make its column wide.
    for number, title in enumerate(heading):
        words_pt = [_width_pt(word) for word in title.split()]
        widths_pt[number] = max(widths_pt[number], *words_pt, 0.0)
    free_pt = TEXT_WIDTH_PT - BETWEEN_COLUMNS_PT * (len(widths_pt) - 1)
    while sum(widths_pt) > free_pt and max(widths_pt) > NARROWEST_PT:
        widest = widths_pt.index(max(widths_pt))
        widths_pt[widest] = max(0.9 * widths_pt[widest], NARROWEST_PT)
    return widths_pt


def _width_pt(cell: str) -> float:
    widest_pt = max((width_pt(line, TEXT_PT) for line in cell.splitlines()), default=0.0)
    return widest_pt / PART_OF_WIDTH + 1.0
