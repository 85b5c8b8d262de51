"""A report as one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import html
import io
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Dict, List, Sequence, Tuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESOLUTION_DPI = 110
STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse}td,th{text-align:left;padding:.15rem 1rem .15rem 0;"
    "vertical-align:top}img{max-width:100%}.warning{color:#a00;font-weight:bold}"
    "figure{margin:1rem 0}figcaption{color:#555}"
)


@dataclass
class Section:
    """One part of a report.

    Attributes:
        title: Its heading.
        warnings: Sentences that must not be overlooked.
        lines: Other sentences.
        rows: Rows of a table.
        figures: Caption and figure.
    """

    title: str
    warnings: List[str] = field(default_factory=list)
    lines: List[str] = field(default_factory=list)
    rows: Sequence[Tuple[str, ...]] = ()
    figures: List[Tuple[str, Figure]] = field(default_factory=list)


def page(title: str, sections: Sequence[Section]) -> str:
    """Return the HTML of a report; nothing in it is loaded from elsewhere."""
    body = "\n".join(_section(one) for one in sections)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title><style>{STYLE}</style></head>\n"
        f"<body><h1>{html.escape(title)}</h1>\n{body}\n</body></html>\n"
    )


def table(values: Dict[str, str]) -> List[Tuple[str, ...]]:
    """Return titles and texts as rows."""
    return list(values.items())


def _section(section: Section) -> str:
    parts = [f"<h2>{html.escape(section.title)}</h2>"]
    parts += [f'<p class="warning">{html.escape(one)}</p>' for one in section.warnings]
    parts += [f"<p>{html.escape(one)}</p>" for one in section.lines]
    if section.rows:
        cells = ("".join(f"<td>{html.escape(one)}</td>" for one in row) for row in section.rows)
        parts.append("<table>" + "".join(f"<tr>{row}</tr>" for row in cells) + "</table>")
    for caption, figure in section.figures:
        parts.append(
            f'<figure><img alt="{html.escape(caption)}" src="{_embedded(figure)}">'
            f"<figcaption>{html.escape(caption)}</figcaption></figure>"
        )
    return "\n".join(parts)


def _embedded(figure: Figure) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION_DPI)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
