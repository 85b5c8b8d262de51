"""Tables that people write for a trial: CSV in UTF-8 with a row per lane, target or candidate.

Commas separate the cells, or semicolons where the decimals have a comma. Lines above the heading
that begin with # are remarks.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from typing import Dict, List, Mapping, NoReturn, Sequence

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.message import Message
from gpr20_common.terminal_text import is_shown

MOST_CHARACTERS = 200
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[-+]?[0-9]{1,3})?", re.ASCII | re.I)
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+")


@dataclass(frozen=True)
class Row:
    """One row of a table: its place in a file, and the texts of its cells by their columns."""

    file: str
    line: int
    cells: Mapping[str, str]

    def text(self, column: str) -> str:
        """Return a cell that must hold a text.

        Raises:
            UnreadableFileError: It is empty, too long or cannot be shown.
        """
        cell = self.cells.get(column, "")
        if not 0 < len(cell) <= MOST_CHARACTERS or not all(map(is_shown, cell)):
            self.refuse(column, Message("a text of 1 to {most} letters", most=MOST_CHARACTERS))
        return cell

    def number(self, column: str, lowest: float, highest: float) -> float:
        """Return the number in a cell.

        Raises:
            UnreadableFileError: It is no number, or outside the bounds, which are allowed.
        """
        cell = self.cells.get(column, "")
        number = float(cell) if _NUMBER.fullmatch(cell) else math.nan
        if not lowest <= number <= highest:
            self.refuse(column, Message("a number, {low:g} to {high:g}", low=lowest, high=highest))
        return number

    def refuse(self, column: str, allowed: Message) -> NoReturn:
        """Refuse a cell.

        Raises:
            UnreadableFileError: Always.
        """
        raise _refused(
            self.file,
            self.line,
            Message(
                "{value} in column {column} is not allowed; write {allowed}",
                value=repr(self.cells.get(column, "")[:64]),
                column=column,
                allowed=allowed,
            ),
        )


def read_table(
    content: bytes, file: str, required: Sequence[str], at_least_one: bool = False
) -> List[Row]:
    """Return the rows of a table.

    Args:
        content: The CSV.
        file: Its name, for messages.
        required: Columns that it must have; each row names another thing in the first of them.
        at_least_one: Whether it must have a row.

    Raises:
        UnreadableFileError: It is no such table; the message says where and what is allowed.
    """
    try:
        lines = content.decode("utf-8-sig").splitlines(keepends=True)
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise _refused(file, line, Message("save the table as CSV in UTF-8")) from error
    first = next((at for at, one in enumerate(lines) if not one.startswith("#")), len(lines))
    heading = "".join(lines[first : first + 1])
    comma = "," if "," in heading or ";" not in heading else ";"
    reader = csv.reader(lines[first:], delimiter=comma, strict=True)
    columns: List[str] = []
    rows: List[Row] = []
    try:
        for found in reader:
            line, cells = first + reader.line_num, [one.strip() for one in found]
            if columns and any(cells):
                rows.append(_row(file, line, columns, cells, comma))
            columns = columns or cells
    except csv.Error as error:
        reason = Message("the quotes are wrong", details=error)
        raise _refused(file, first + reader.line_num, reason) from error
    if not set(required) <= set(columns) or len({*columns, ""}) != len(columns) + 1:
        wanted = Message(
            "the heading must name each column once, among them {columns}",
            columns=", ".join(required),
        )
        raise _refused(file, first + 1, wanted)
    if at_least_one and not rows:
        raise _refused(file, first + 1, Message("there is no row below the heading"))
    named: Dict[str, Row] = {}
    for row in rows:
        if named.setdefault(row.text(required[0]), row) is not row:
            row.refuse(required[0], Message("a name that no other row has"))
    return rows


def _row(file: str, line: int, columns: List[str], cells: List[str], comma: str) -> Row:
    if len(cells) != len(columns):
        reason = Message(
            "there are {count} cells, but {wanted} columns", count=len(cells), wanted=len(columns)
        )
        raise _refused(file, line, reason)
    if comma == ";":
        cells = [one.replace(",", ".") if _DECIMAL_COMMA.fullmatch(one) else one for one in cells]
    return Row(file, line, dict(zip(columns, cells)))


def _refused(file: str, line: int, reason: Message) -> UnreadableFileError:
    return UnreadableFileError(
        Message("{file}, line {line}: {reason}", file=file, line=line, reason=reason),
        fault=faults.FILE_CONTENT,
    )
