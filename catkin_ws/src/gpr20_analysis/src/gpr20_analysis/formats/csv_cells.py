"""Texts in CSV files: a spreadsheet takes none of them for a formula.

Texts that people type, or that a file holds, may begin like a formula, which a spreadsheet runs
when it opens the file. They get an apostrophe before that; `cell_text` takes it away again. The
same holds behind a comma, semicolon, tab or line break in a text: a spreadsheet that expects
another separator, as in countries with a decimal comma, begins a new cell there, whatever the
quotes say.
"""

from __future__ import annotations

import re
from typing import Any

# A quote at the beginning of a cell would make one cell of the lines after it.
_FORMULA = '\'*(?="|[ \u00a0"]*[=+\\-@\uff1d\uff0b\uff0d\uff20\t\r\n])'
_PLACE = re.compile(f"(?:^|(?<=[,;\t\r\n])){_FORMULA}")
_NUMBER = re.compile(r"[-+]?[0-9]+([.][0-9]+)?")


def csv_cell(value: Any) -> Any:
    """Return a value as a cell of a CSV file; numbers, also those in a text, stay as they are."""
    if value is None:
        return ""
    if not isinstance(value, str) or _NUMBER.fullmatch(value):
        return value
    return _PLACE.sub(lambda found: f"'{found.group()}", value)


def cell_text(cell: str) -> str:
    """Return the text of a cell that a CSV file of gpr20 holds, without what protects it."""
    return _PLACE.sub(lambda found: found.group()[1:], cell)
