"""A report as PDF: pages of text, then a page for each figure."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator, List, Tuple

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from gpr20_analysis.plotting.noted_figure import NotedFigure, wrapped
from gpr20_analysis.report.pdf_text import (
    BOTTOM_PT,
    LEFT_PT,
    PAGE_PT,
    POINTS_PER_IN,
    SMALL_PT,
    TEXT_WIDTH_PT,
    TOP_PT,
    Line,
    text_pages,
)
from gpr20_analysis.report.records import Report
from gpr20_common.catalogue import Catalogue

RESOLUTION_DPI = 200


def write_pdf(path: Path, report: Report, catalogue: Catalogue) -> None:
    """Write a report.

    Args:
        path: The file.
        report: What it shows.
        catalogue: Language of the page numbers.

    Raises:
        OSError: It cannot be written.
    """
    with PdfPages(str(path), metadata={"Title": report.title}) as pages:
        for page in pages_of(report, catalogue):
            pages.savefig(page, dpi=RESOLUTION_DPI)


def pages_of(report: Report, catalogue: Catalogue) -> Iterator[Figure]:
    """Yield each page of a report.

    Args:
        report: What it shows.
        catalogue: Language of the page numbers.

    Yields:
        The pages of text, then the figures.
    """
    texts = text_pages(report)
    figures = [
        (f"{section.title}: {report.caption(caption)}", figure)
        for section in report.sections
        for caption, figure in section.figures
    ]
    count = len(texts) + len(figures)
    for number, lines in enumerate(texts, 1):
        page = catalogue.tr("page {number} of {count}", number=number, count=count)
        yield _sheet(lines, report, page)
    for number, (caption, figure) in enumerate(figures, len(texts) + 1):
        page = catalogue.tr("page {number} of {count}", number=number, count=count)
        below = [one for one in (report.footer, f"{page}, {report.title}") if one]
        if isinstance(figure, NotedFigure):
            figure.add_lines(above=[caption], below=below)
        yield figure


def _sheet(lines: List[Line], report: Report, page: str) -> Figure:
    width_pt, height_pt = PAGE_PT
    sheet = Figure(figsize=(width_pt / POINTS_PER_IN, height_pt / POINTS_PER_IN))
    width_in = TEXT_WIDTH_PT / POINTS_PER_IN
    # The title may be as long as the identifier of a survey from elsewhere.
    below = [report.footer, *wrapped([f"{page}, {report.title}"], width_in, SMALL_PT)[:1]]
    around: List[Tuple[float, str, str]] = [
        (height_pt - TOP_PT / 2.0, report.banner, "bottom"),
        (BOTTOM_PT - SMALL_PT, "\n".join(below), "top"),
    ]
    for up_pt, text, edge in around:
        sheet.text(
            LEFT_PT / width_pt, up_pt / height_pt, text, size=SMALL_PT, color="firebrick",
            va=edge, parse_math=False,
        )  # fmt: skip
    up_pt = height_pt - TOP_PT
    for line in lines:
        for right_pt, text in line.cells:
            sheet.text(
                (LEFT_PT + right_pt) / width_pt, up_pt / height_pt, text, size=line.size_pt,
                color=line.colour, weight=line.weight, va="top", parse_math=False,
            )  # fmt: skip
        up_pt -= line.height_pt
    return sheet
