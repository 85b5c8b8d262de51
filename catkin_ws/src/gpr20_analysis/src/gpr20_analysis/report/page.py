"""A report as one self-contained HTML file."""

from __future__ import annotations

import base64
import html
import io
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, List, Sequence, Tuple

from gpr20_common.catalogue import Language

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESOLUTION_DPI = 110
STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:70rem;margin:2rem auto;"
    "padding:0 1rem}h1{font-size:1.5rem;margin-bottom:0}h2{font-size:1.15rem;margin-top:2rem;"
    "border-bottom:1px solid #ccc}table{border-collapse:collapse;margin:.5rem 0}"
    "td,th{text-align:left;padding:.15rem 1.2rem .15rem 0;vertical-align:top}"
    "td{white-space:pre-line}td:first-child{color:#555;white-space:nowrap}"
    "tr+tr td{border-top:1px solid #eee}"
    "p{margin:.3rem 0}.warning{color:#8a0000;font-weight:600}"
    "section:first-of-type{border-left:.5rem solid #2a7a2a;background:#f3f8f3;padding:.2rem 1rem}"
    "section:first-of-type h2{border:0;margin:.3rem 0}"
    "section.bad:first-of-type{border-color:#b00000;background:#fbf2f2}"
    "img{max-width:100%}figure{margin:1rem 0;break-inside:avoid}figcaption{color:#555}"
)


@dataclass
class Section:
    """One part of a report.

    Attributes:
        title: Heading.
        warnings: Sentences that are highlighted.
        lines: Other sentences.
        rows: Rows of a table.
        heading: Titles of its columns.
        figures: Captions and figures.
    """

    title: str
    warnings: List[str] = field(default_factory=list)
    lines: List[str] = field(default_factory=list)
    rows: Sequence[Tuple[str, ...]] = ()
    heading: Tuple[str, ...] = ()
    figures: List[Tuple[str, Figure]] = field(default_factory=list)

    @property
    def empty(self) -> bool:
        """Whether there is nothing below the heading."""
        return not (self.warnings or self.lines or self.rows or self.figures)


def page(title: str, sections: Sequence[Section], language: Language = Language.ENGLISH) -> str:
    """Return the HTML of a report, which loads nothing from elsewhere.

    Args:
        title: Title of the page.
        sections: What it shows.
        language: The language of the texts.
    """
    body = "\n".join(_section(one) for one in sections)
    return (
        f'<!DOCTYPE html>\n<html lang="{language.value}"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title><style>{STYLE}</style></head>\n"
        f"<body><h1>{html.escape(title)}</h1>\n{body}\n</body></html>\n"
    )


def _section(section: Section) -> str:
    parts = [f"<h2>{html.escape(section.title)}</h2>"]
    parts += [f'<p class="warning">{html.escape(one)}</p>' for one in section.warnings]
    parts += [f"<p>{html.escape(one)}</p>" for one in section.lines]
    if section.rows:
        cells = ("".join(f"<td>{html.escape(one)}</td>" for one in row) for row in section.rows)
        titles = "".join(f"<th>{html.escape(one)}</th>" for one in section.heading)
        rows = [f"<tr>{row}</tr>" for row in ([titles] if titles else []) + list(cells)]
        parts.append(f"<table>{''.join(rows)}</table>")
    for caption, figure in section.figures:
        parts.append(
            f'<figure><img alt="{html.escape(caption)}" src="{_embedded(figure)}">'
            f"<figcaption>{html.escape(caption)}</figcaption></figure>"
        )
    return f'<section class="{"bad" if section.warnings else "good"}">' + "\n".join(
        [*parts, "</section>"]
    )


def _embedded(figure: Figure) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION_DPI)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
