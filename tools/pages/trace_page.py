"""Write the table of a trace's fields in docs/reference/formats.md, from the table of the software.

Usage: PYTHONPATH with gpr20_survey and gpr20_common; tools/pages/trace_page.py
"""

from __future__ import annotations

import re
from pathlib import Path

from gpr20_survey.trace.trace import TRACE_FIELDS
from gpr20_survey.trace.trace_form import TraceField

PAGE = Path(__file__).resolve().parents[2] / "docs/reference/formats.md"
HEAD = "| key and field | type in the message | unit | not known there | meaning |\n"
RULE = "| --- | --- | --- | --- | --- |\n"


def page(text: str) -> str:
    """Return a page with the table of today in place of the one that it has."""
    rows = "".join(map(_row, TRACE_FIELDS))
    pattern = re.escape(HEAD + RULE) + r"(\|.*\n)*"
    return re.sub(pattern, lambda _: HEAD + RULE + rows, text)


def _row(field: TraceField) -> str:
    unknown = {None: "", "": "empty"}.get(field.unknown, str(field.unknown))
    kind = field.form.ros
    return f"| `{field.name}` | `{kind}` | {field.unit} | {unknown} | {field.meaning} |\n"


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
