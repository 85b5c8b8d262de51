"""Text from files and devices on a terminal, where it must neither hide, fake nor control."""

from __future__ import annotations

import io
import re
import sys
import unicodedata
from pathlib import PurePath
from typing import Optional, TextIO, Union

_REFUSED_CATEGORIES = frozenset({"Cc", "Cs", "Zl", "Zp"})
# They reverse the order in which the text after them is shown.
_DIRECTIONS = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
# Python's characters for the bytes of a file's name that are no text.
_NO_TEXT = re.compile("[\ud800-\udfff]")
_FIRST_BYTE, _LAST_BYTE, _BYTE = "\udc80", "\udcff", 0xDC00


def is_shown(character: str) -> bool:
    """Return whether a character is shown, and as what it is: it controls nothing."""
    # Not str.isprintable(), which refuses the joiners that some scripts are written with.
    category = unicodedata.category(character)
    return category not in _REFUSED_CATEGORIES and character not in _DIRECTIONS


def printable(text: Union[str, PurePath]) -> str:
    r"""Return a text, or a file's name, as one line that can be sent and shown, whatever it holds.

    What is not shown is written as in Python: an escape as `\x1b`, a line break as `\n`.
    """
    return "".join(map(_written, str(text)))


def storable(text: Union[str, PurePath]) -> str:
    r"""Return a text as UTF-8 can hold it: bytes of a file's name that are no text as `\xff`."""
    return _NO_TEXT.sub(lambda found: _written(found.group()), str(text))


def say(*lines: Union[str, PurePath], file: Optional[TextIO] = None, flush: bool = False) -> None:
    """Print lines as `printable` shows them: none can add lines or control the terminal."""
    print(*map(printable, lines), sep="\n", file=file, flush=flush)


def enable_line_buffering() -> None:
    """Let the standard output pass each line on when it ends.

    Python keeps back several kilobytes of what goes into a file, a pipe or the journal, and rospy
    does not flush: the log of a node would lag by hours and end before the lines that say why.
    """
    # One that is no buffered file needs nothing.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)


def _written(character: str) -> str:
    if is_shown(character):
        return character
    if _FIRST_BYTE <= character <= _LAST_BYTE:
        return f"\\x{ord(character) - _BYTE:02x}"
    return character.encode("unicode_escape").decode("ascii")
