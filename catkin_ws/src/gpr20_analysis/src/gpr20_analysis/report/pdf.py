"""A report as PDF, in the same order as the page."""

from __future__ import annotations

import io
from functools import partial
from html import escape
from pathlib import Path
from typing import IO, TYPE_CHECKING, List, Sequence, Tuple

import matplotlib
from reportlab.lib import colors
from reportlab.lib.pagesizes import A4
from reportlab.lib.styles import ParagraphStyle
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import (
    CondPageBreak,
    Flowable,
    Image,
    KeepTogether,
    LongTable,
    Paragraph,
    SimpleDocTemplate,
    TableStyle,
)

from gpr20_analysis.report.records import Report, Section
from gpr20_common.catalogue import Catalogue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FONT, BOLD = "DejaVuSans", "DejaVuSans-Bold"
"""Those of the figures, which matplotlib brings; they have the letters of most languages."""
LEFT_PT, TOP_PT, BOTTOM_PT = 48.0, 52.0, 60.0
TEXT_WIDTH_PT = A4[0] - 2.0 * LEFT_PT
TEXT_HEIGHT_PT = A4[1] - TOP_PT - BOTTOM_PT
POINTS_PER_IN, RESOLUTION_DPI = 72.0, 200
BETWEEN_COLUMNS_PT, NARROWEST_PT = 12.0, 36.0
Drawn = Sequence[Tuple[str, bytes]]
"""Captions and figures of a section."""
PART_OF_PAGE = 0.9
"""The highest figure, so that its caption is on the same page."""

TEXT = ParagraphStyle(
    "text", fontName=FONT, fontSize=8.0, leading=11.5, spaceAfter=2.0, splitLongWords=1
)
WARNING = ParagraphStyle("warning", TEXT, fontName=BOLD, textColor=colors.darkred)
NOTICE = ParagraphStyle(
    "notice", TEXT, fontName=BOLD, textColor=colors.firebrick, borderWidth=1.0, borderPadding=4.0,
    borderColor=colors.firebrick, spaceBefore=7.0, spaceAfter=9.0,
)  # fmt: skip
TITLE = ParagraphStyle("title", TEXT, fontName=BOLD, fontSize=14.0, leading=18.0)
HEADING = ParagraphStyle(
    "heading", TEXT, fontName=BOLD, fontSize=10.5, leading=14.0, spaceBefore=12.0, spaceAfter=4.0,
)  # fmt: skip
COLUMN_TITLE = ParagraphStyle("column", TEXT, textColor=colors.dimgrey)
CAPTION = ParagraphStyle("caption", COLUMN_TITLE, spaceBefore=8.0)
MARGIN = ParagraphStyle(
    "margin", TEXT, fontSize=7.0, leading=9.0, textColor=colors.firebrick, spaceAfter=0.0
)
ROWS = TableStyle(
    [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LEFTPADDING", (0, 0), (-1, -1), 0.0),
        ("RIGHTPADDING", (0, 0), (-1, -1), BETWEEN_COLUMNS_PT),
        ("TOPPADDING", (0, 0), (-1, -1), 1.0),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 1.0),
        ("LINEBELOW", (0, 0), (-1, -1), 0.25, colors.gainsboro),
    ]
)


def write_pdf(path: Path, report: Report, catalogue: Catalogue) -> None:
    """Write a report.

    Args:
        path: The file.
        report: What it shows.
        catalogue: Language of the page numbers.

    Raises:
        OSError: It cannot be written.
    """
    folder = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    for name in (FONT, BOLD):
        pdfmetrics.registerFont(TTFont(name, str(folder / f"{name}.ttf")))
    drawn = [[(text, _png(figure)) for text, figure in one.figures] for one in report.sections]
    # The number of pages is known when they have been made once.
    count = _make(io.BytesIO(), report, drawn, catalogue, 0)
    with path.open("wb") as stream:
        _make(stream, report, drawn, catalogue, count)


def _make(
    stream: IO[bytes], report: Report, drawn: Sequence[Drawn], catalogue: Catalogue, count: int
) -> int:
    document = SimpleDocTemplate(
        stream, pagesize=A4, leftMargin=LEFT_PT, rightMargin=LEFT_PT, topMargin=TOP_PT,
        bottomMargin=BOTTOM_PT, title=report.title, lang=report.language.value,
    )  # fmt: skip
    parts: List[Flowable] = [_text(report.title, TITLE)]
    for section, figures in zip(report.sections, drawn):
        parts += _section(section)
        parts += [_figure(report.caption(text), png) for text, png in figures]
    around = partial(_margins, report=report, catalogue=catalogue, count=count)
    document.build(parts, onFirstPage=around, onLaterPages=around)
    return int(document.page)


def _margins(
    canvas: Canvas, document: SimpleDocTemplate, report: Report, catalogue: Catalogue, count: int
) -> None:
    page = catalogue.tr("page {number} of {count}", number=document.page, count=count)
    above = _text(report.banner, MARGIN)
    above.wrap(TEXT_WIDTH_PT, TOP_PT)
    above.drawOn(canvas, LEFT_PT, A4[1] - TOP_PT / 2.0)
    below = _text("\n".join(filter(None, [report.footer, f"{page}, {report.title}"])), MARGIN)
    _, height_pt = below.wrap(TEXT_WIDTH_PT, BOTTOM_PT)
    below.drawOn(canvas, LEFT_PT, BOTTOM_PT - MARGIN.leading - height_pt)


def _section(section: Section) -> List[Flowable]:
    # A heading is not the last line of a page.
    parts = [CondPageBreak(5.0 * HEADING.leading), _text(section.title, HEADING)]
    if section.notice:
        parts.append(_text(section.notice, NOTICE))
    parts += [_text(one, WARNING) for one in section.warnings]
    parts += [_text(one, TEXT) for one in section.lines]
    return [*parts, *([_table(section)] if section.rows else [])]


def _text(text: str, style: ParagraphStyle) -> Paragraph:
    # What a survey says is never markup.
    return Paragraph(escape(_letters(text, style.fontName)).replace("\n", "<br/>"), style)


def _letters(text: str, font: str) -> str:
    """Return a text with the codes of letters that a font lacks: a box would lose them."""
    known = pdfmetrics.getFont(font).face.charToGlyph
    return "".join(
        one if ord(one) in known or one.isspace() else one.encode("unicode_escape").decode("ascii")
        for one in text
    )


def _table(section: Section) -> LongTable:
    rows = [[_text(cell, TEXT) for cell in row] for row in section.rows]
    titles = [[_text(cell, COLUMN_TITLE) for cell in section.heading]] if section.heading else []
    widths_pt = [one + BETWEEN_COLUMNS_PT for one in _column_widths(section.heading, section.rows)]
    # A row that is higher than a page, such as long notes, continues on the next one.
    return LongTable(
        [*titles, *rows], widths_pt, repeatRows=len(titles), splitInRow=1, hAlign="LEFT",
        style=ROWS,
    )  # fmt: skip


def _column_widths(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> List[float]:
    """Return widths of columns that fit beside each other; the widest are narrowed first."""
    widths_pt = [max(_width_pt(cell) for cell in column) for column in zip(*rows)]
    # A title is divided between words, rather than make its column wide.
    for number, title in enumerate(heading):
        words_pt = [_width_pt(word) for word in title.split()]
        widths_pt[number] = max(widths_pt[number], *words_pt, 0.0)
    free_pt = TEXT_WIDTH_PT - BETWEEN_COLUMNS_PT * len(widths_pt)
    while sum(widths_pt) > free_pt and max(widths_pt) > NARROWEST_PT:
        widest = widths_pt.index(max(widths_pt))
        widths_pt[widest] = max(0.9 * widths_pt[widest], NARROWEST_PT)
    return widths_pt


def _width_pt(cell: str) -> float:
    lines = _letters(cell, FONT).splitlines() or [""]
    return 1.0 + max(float(pdfmetrics.stringWidth(one, FONT, TEXT.fontSize)) for one in lines)


def _png(figure: Figure) -> bytes:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION_DPI)
    return stream.getvalue()


def _figure(caption: str, png: bytes) -> KeepTogether:
    image = Image(io.BytesIO(png))
    scale = min(
        POINTS_PER_IN / RESOLUTION_DPI,
        TEXT_WIDTH_PT / image.imageWidth,
        PART_OF_PAGE * TEXT_HEIGHT_PT / image.imageHeight,
    )
    image.drawWidth, image.drawHeight = scale * image.imageWidth, scale * image.imageHeight
    return KeepTogether([_text(caption, CAPTION), image])
