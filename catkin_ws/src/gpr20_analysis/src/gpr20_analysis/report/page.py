"""A report, the one self-contained HTML file that it is, and its print as PDF."""

from __future__ import annotations

import base64
import html
import io
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, List, Sequence, Tuple

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import ExportError, MissingLibraryError, wrong_ending
from gpr20_common.catalogue import Language
from gpr20_common.message import Message

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HTML, PDF = ".html", ".pdf"
RESOLUTION_DPI = 110
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PRINT_LIMIT_S = 120.0
STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:70rem;margin:0 auto;"
    "padding:0 1rem}h1{font-size:1.5rem;margin:1rem 0}h2{font-size:1.15rem;margin-top:2rem;"
    "border-bottom:1px solid #ccc}table{border-collapse:collapse;margin:.5rem 0}"
    "td,th{text-align:left;padding:.15rem 1.2rem .15rem 0;vertical-align:top}"
    "td{white-space:pre-wrap}td:first-child{color:#555;white-space:nowrap}"
    "tr+tr td{border-top:1px solid #eee}"
    "p{margin:.3rem 0}.warning{color:#8a0000;font-weight:600}summary{cursor:pointer}"
    ".notice{border:2px solid #b00000;padding:.4rem .8rem;margin:.6rem 0;font-weight:700}"
    "header.banner{position:sticky;top:0;margin:0 -1rem;padding:.2rem 1rem;background:#b00000;"
    "color:#fff;font-weight:700}footer{margin:2rem 0 1rem;color:#555}"
    "section:first-of-type h2{border:0;margin:.3rem 0;font-size:1.35rem}"
    "figure{margin:1rem 0;break-inside:avoid}img{max-width:100%}figcaption{color:#555}"
    "section:first-of-type img{width:100%}"
    # What is fixed is printed on every page.
    "@page{size:A4;margin:15mm}@media print{body{padding-top:2rem;max-width:none}"
    "header.banner{position:fixed;width:100%;color:#b00000;background:#fff;"
    "border-bottom:2px solid #b00000}h2{break-after:avoid}details:not([open]){display:none}}"
)


@dataclass
class Section:
    """One part of a report.

    Attributes:
        title: Heading.
        notice: Sentence in a frame below it; empty: none.
        warnings: Sentences that are highlighted.
        lines: Other sentences.
        rows: Rows of a table, below the figures that come first.
        heading: Titles of its columns.
        more: Rows that are shown to who opens them, and the sentence that says what they are.
        figures: Captions and figures.
        figures_first: Whether the figures come before the table.
    """

    title: str
    notice: str = ""
    warnings: List[str] = field(default_factory=list)
    lines: List[str] = field(default_factory=list)
    rows: Sequence[Tuple[str, ...]] = ()
    heading: Tuple[str, ...] = ()
    more: Tuple[str, Sequence[Tuple[str, ...]]] = ("", ())
    figures: List[Tuple[str, Figure]] = field(default_factory=list)
    figures_first: bool = False

    @property
    def empty(self) -> bool:
        """Whether there is nothing below the heading."""
        return not (self.notice or self.warnings or self.lines or self.rows or self.figures)


@dataclass(frozen=True)
class Report:
    """A report.

    Attributes:
        title: Its title.
        sections: What it shows, in order.
        language: Language of the texts.
        mark: Word in every caption, "SIMULATED" if the survey is simulated; else empty.
        banner: Sentence at the top of every page that says the same; else empty.
        footer: Sentence at the bottom.
    """

    title: str
    sections: Sequence[Section]
    language: Language = Language.ENGLISH
    mark: str = ""
    banner: str = ""
    footer: str = ""


def check_report_path(output: Path) -> None:
    """Check the ending of a report's file.

    Raises:
        ExportError: It is another one.
    """
    if output.suffix != HTML:
        raise ExportError(wrong_ending(output, (HTML,)))


def save_report(made: Report, output: Path) -> None:
    """Write a report.

    Raises:
        AnalysisError: It cannot be written.
    """
    with atomic_output(output) as place:
        place.write_text(page(made), encoding="utf-8")


def write_pdf(report: Path, output: Path) -> None:
    """Print the file of a report as PDF, by a browser or WeasyPrint.

    Raises:
        MissingLibraryError: There is neither.
        ExportError: The path has another ending, or the program failed.
    """
    if output.suffix != PDF:
        raise ExportError(wrong_ending(output, (PDF,)))
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    with atomic_output(output) as place:
        if browser is not None:
            command = [browser, "--headless", "--no-sandbox", "--disable-gpu",
                       "--no-pdf-header-footer", f"--print-to-pdf={place}",
                       report.resolve().as_uri()]  # fmt: skip
        elif shutil.which("weasyprint"):
            command = ["weasyprint", str(report), str(place)]
        else:
            raise MissingLibraryError(
                Message("--pdf needs Chromium or WeasyPrint; install one, or print the page")
            )
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=PRINT_LIMIT_S,
            check=False,
        )  # fmt: skip
        if done.returncode != 0 or not place.exists():
            details = done.stderr.decode("utf-8", "replace")[-500:]
            raise ExportError(Message("the report was not printed", details=details))


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
    figures = [_figure(text, figure, report) for text, figure in section.figures]
    table = [_table(section.heading, section.rows)] if section.rows else []
    parts += [*figures, *table] if section.figures_first else [*table, *figures]
    summary, rows = section.more
    if rows:
        inside = _table(section.heading, rows)
        parts.append(f"<details><summary>{html.escape(summary)}</summary>{inside}</details>")
    elif summary:
        parts.append(f"<p>{html.escape(summary)}</p>")
    return "<section>" + "\n".join([*parts, "</section>"])


def _table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    titles = "".join(f"<th>{html.escape(one)}</th>" for one in heading)
    cells = ("".join(f"<td>{html.escape(one)}</td>" for one in row) for row in rows)
    lines = [f"<tr>{row}</tr>" for row in ([titles] if titles else []) + list(cells)]
    return f"<table>{''.join(lines)}</table>"


def _figure(text: str, figure: Figure, report: Report) -> str:
    caption = html.escape(f"{text} ({report.mark})" if report.mark else text)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION_DPI)
    image = "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
    return f'<figure><img alt="{caption}" src="{image}"><figcaption>{caption}</figcaption></figure>'
