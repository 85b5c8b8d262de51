"""A report, and the one self-contained HTML file that it is."""

from __future__ import annotations

import base64
import html
import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, List, Sequence, Tuple

from gpr20_analysis.atomic_output import atomic_output
from gpr20_common.catalogue import Language

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HTML = ".html"
RESOLUTION_DPI = 110
STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:70rem;margin:0 auto;"
    "padding:0 1rem 2rem}h1{font-size:1.5rem;margin:1rem 0}h2{font-size:1.15rem;margin-top:2rem;"
    "border-bottom:1px solid #ccc}table{border-collapse:collapse;margin:.5rem 0}"
    "td,th{text-align:left;padding:.15rem 1.2rem .15rem 0;vertical-align:top}"
    "td{white-space:pre-wrap}td:first-child{color:#555;white-space:nowrap}"
    "tr+tr td{border-top:1px solid #eee}"
    "p{margin:.3rem 0}.warning{color:#8a0000;font-weight:600}summary{cursor:pointer}"
    ".notice{border:2px solid #b00000;padding:.4rem .8rem;margin:.6rem 0;font-weight:700}"
    "header{position:sticky;top:0;margin:0 -1rem;padding:.2rem 1rem;background:#b00000;"
    "color:#fff;font-weight:700}section:first-of-type h2{border:0;margin:.3rem 0;"
    "font-size:1.35rem}figure{margin:1rem 0;break-inside:avoid}img{max-width:100%}"
    "section:first-of-type img{width:100%}"
    # What is fixed is printed on every page.
    "@page{size:A4;margin:15mm}@media print{body{padding-top:2rem;max-width:none}"
    "header{position:fixed;width:100%;color:#b00000;background:#fff;"
    "border-bottom:2px solid #b00000}h2{break-after:avoid}details:not([open]){display:none}}"
)


@dataclass
class Section:
    """One part of a report, in the order in which it is shown.

    Attributes:
        title: Heading.
        notice: Sentence in a frame below it; empty: none.
        warnings: Sentences that are highlighted.
        lines: Other sentences.
        figures: Figures, which say themselves what they are.
        heading: Titles of the columns of the table.
        rows: Its rows.
        more: Rows that are shown to who opens them, and the sentence that says what they are.
    """

    title: str
    notice: str = ""
    warnings: List[str] = field(default_factory=list)
    lines: List[str] = field(default_factory=list)
    figures: List[Figure] = field(default_factory=list)
    heading: Tuple[str, ...] = ()
    rows: Sequence[Tuple[str, ...]] = ()
    more: Tuple[str, Sequence[Tuple[str, ...]]] = ("", ())


@dataclass(frozen=True)
class Report:
    """A report.

    Attributes:
        title: Its title.
        sections: What it shows, in order.
        language: Language of the texts.
        banner: Sentence at the top of every page that says the same; else empty.
    """

    title: str
    sections: Sequence[Section]
    language: Language = Language.ENGLISH
    banner: str = ""


def save_report(made: Report, output: Path) -> None:
    """Write a report.

    Raises:
        AnalysisError: It cannot be written.
    """
    with atomic_output(output) as place:
        place.write_text(page(made), encoding="utf-8")


def page(report: Report) -> str:
    """Return the HTML of a report, which loads nothing from elsewhere."""
    banner = _tag("header", report.banner) if report.banner else ""
    return (
        f'<!DOCTYPE html>\n<html lang="{report.language.value}"><head><meta charset="utf-8">'
        f"{_tag('title', report.title)}<style>{STYLE}</style></head>\n<body>{banner}"
        f"{_tag('h1', report.title)}\n{''.join(map(_section, report.sections))}</body></html>\n"
    )


def _section(section: Section) -> str:
    parts = [_tag("h2", section.title)]
    parts += [_tag("p", section.notice, "notice")] if section.notice else []
    parts += [_tag("p", one, "warning") for one in section.warnings]
    parts += [_tag("p", one) for one in section.lines]
    parts += [_figure(one) for one in section.figures]
    if section.rows:
        parts.append(_table(section.heading, section.rows))
    summary, rows = section.more
    if summary:
        inside = _tag("summary", summary) + _table(section.heading, rows)
        parts.append(f"<details>{inside}</details>")
    return "<section>" + "\n".join([*parts, "</section>\n"])


def _tag(name: str, text: str, style: str = "") -> str:
    kind = f' class="{style}"' if style else ""
    return f"<{name}{kind}>{html.escape(text)}</{name}>"


def _table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["".join(_tag("th", one) for one in heading)] if heading else []
    lines += ["".join(_tag("td", one) for one in row) for row in rows]
    return "<table>" + "".join(f"<tr>{one}</tr>" for one in lines) + "</table>"


def _figure(figure: Figure) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION_DPI)
    image = base64.b64encode(stream.getvalue()).decode("ascii")
    title = html.escape(figure.texts[0].get_text())
    return f'<figure><img alt="{title}" src="data:image/png;base64,{image}"></figure>'
