"""A report as one self-contained HTML file."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING

from gpr20_analysis.report.records import Report, Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESOLUTION_DPI = 110
STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:70rem;margin:0 auto;"
    "padding:0 1rem}h1{font-size:1.5rem;margin:1rem 0}h2{font-size:1.15rem;margin-top:2rem;"
    "border-bottom:1px solid #ccc}table{border-collapse:collapse;margin:.5rem 0}"
    "td,th{text-align:left;padding:.15rem 1.2rem .15rem 0;vertical-align:top}"
    "td{white-space:pre-wrap}td:first-child{color:#555;white-space:nowrap}"
    "tr+tr td{border-top:1px solid #eee}"
    "p{margin:.3rem 0}.warning{color:#8a0000;font-weight:600}"
    ".notice{border:2px solid #b00000;padding:.4rem .8rem;margin:.6rem 0;font-weight:700}"
    "header.banner{position:sticky;top:0;margin:0 -1rem;padding:.2rem 1rem;background:#b00000;"
    "color:#fff;font-weight:700}footer{margin:2rem 0 1rem;color:#555}"
    "section:first-of-type{border-left:.5rem solid #2a7a2a;background:#f3f8f3;padding:.2rem 1rem}"
    "section:first-of-type h2{border:0;margin:.3rem 0}"
    "section.bad:first-of-type{border-color:#b00000;background:#fbf2f2}"
    "img{max-width:100%}figure{margin:1rem 0;break-inside:avoid}figcaption{color:#555}"
    # What is fixed is printed on every page.
    "@media print{body{padding-top:2rem}header.banner{position:fixed;width:100%;color:#b00000;"
    "background:#fff;border-bottom:2px solid #b00000}h2{break-after:avoid}}"
)


def page(report: Report) -> str:
    """Return the HTML of a report, which loads nothing from elsewhere."""
    title = html.escape(report.title)
    banner = f'<header class="banner">{html.escape(report.banner)}</header>\n'
    body = "\n".join(_section(one, report) for one in report.sections)
    footer = f"\n<footer>{html.escape(report.footer)}</footer>"
    return (
        f'<!DOCTYPE html>\n<html lang="{report.language.value}"><head><meta charset="utf-8">'
        f"<title>{title}</title><style>{STYLE}</style></head>\n"
        f"<body>{banner if report.banner else ''}<h1>{title}</h1>\n{body}"
        f"{footer if report.footer else ''}\n</body></html>\n"
    )


def _section(section: Section, report: Report) -> str:
    parts = [f"<h2>{html.escape(section.title)}</h2>"]
    if section.notice:
        parts.append(f'<p class="notice">{html.escape(section.notice)}</p>')
    parts += [f'<p class="warning">{html.escape(one)}</p>' for one in section.warnings]
    parts += [f"<p>{html.escape(one)}</p>" for one in section.lines]
    if section.rows:
        cells = ("".join(f"<td>{html.escape(one)}</td>" for one in row) for row in section.rows)
        titles = "".join(f"<th>{html.escape(one)}</th>" for one in section.heading)
        rows = [f"<tr>{row}</tr>" for row in ([titles] if titles else []) + list(cells)]
        parts.append(f"<table>{''.join(rows)}</table>")
    for text, figure in section.figures:
        caption = html.escape(report.caption(text))
        parts.append(
            f'<figure><img alt="{caption}" src="{_embedded(figure)}">'
            f"<figcaption>{caption}</figcaption></figure>"
        )
    return f'<section class="{"bad" if section.warnings else "good"}">' + "\n".join(
        [*parts, "</section>"]
    )


def _embedded(figure: Figure) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION_DPI)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
