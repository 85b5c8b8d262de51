"""Titles and texts in two columns on a terminal."""

from __future__ import annotations

from typing import Iterable, Tuple

from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say

TITLE_WIDTH = 24


def print_rows(rows: Iterable[Tuple[Message, Message]], catalogue: Catalogue) -> None:
    """Print title and text of each row; a text of several lines is indented."""
    for title, text in rows:
        first, *more = catalogue.text(text).splitlines() or [""]
        say(f"{catalogue.text(title) + ':':{TITLE_WIDTH}}{first}".rstrip())
        for line in more:
            say(f"{'':{TITLE_WIDTH}}{line}".rstrip())
