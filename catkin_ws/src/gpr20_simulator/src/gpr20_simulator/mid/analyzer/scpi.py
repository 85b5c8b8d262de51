"""The command language of the instrument: splitting, keywords, numbers."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import List, Optional, Tuple

_LEVEL = re.compile(r"(\[?):([A-Za-z]+)(#?)(\]?)")
# No digit can belong to two repetitions, so a long number that is none is refused in linear time.
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[Ee][+-]?[0-9]{1,3})?")
LONGEST_NUMBER = 64
_SWITCH = {"ON": True, "1": True, "OFF": False, "0": False}


class ScpiError(ValueError):
    """A value that the instrument does not accept."""


@dataclass(frozen=True)
class ScpiCommand:
    """One command of a message.

    Attributes:
        header: Keywords with their colons, or a common command with its star.
        is_query: Whether a question mark followed.
        argument: All that came after the header.
    """

    header: str
    is_query: bool
    argument: str


class HeaderPattern:
    """A documented header, such as `[:SENSe]:TRACe#:SPARams`.

    Capitals are the short form, all letters the long one, nothing between is accepted;
    brackets hold what may be left out, and `#` means a number, 1 if it is missing.
    """

    def __init__(self, pattern: str) -> None:
        self.pattern = pattern
        levels = "".join(_level_expression(match) for match in _LEVEL.finditer(pattern))
        self._expression = re.compile(levels or re.escape(pattern), re.IGNORECASE)

    def match(self, header: str) -> Optional[Tuple[int, ...]]:
        """Return the numbers in the header; None if it is another header."""
        found = self._expression.fullmatch(header)
        if found is None:
            return None
        return tuple(1 if number is None else int(number) for number in found.groups())


def _level_expression(match: re.Match[str]) -> str:
    opening, keyword, number, _closing = match.groups()
    expression = ":" + _keyword_expression(keyword) + (r"(\d{1,4})?" if number else "")
    return f"(?:{expression})?" if opening else expression


def _keyword_expression(keyword: str) -> str:
    pieces = re.split(r"([a-z]+)", keyword)
    return "".join(f"(?:{one})?" if one.islower() else re.escape(one) for one in pieces)


def chosen_keyword(text: str, keywords: Tuple[str, ...]) -> str:
    """Return the short form of the keyword that the text spells, one written like `DISTance`.

    Raises:
        ScpiError: It spells none of them.
    """
    for keyword in keywords:
        if re.fullmatch(_keyword_expression(keyword), text.strip(), re.IGNORECASE):
            return "".join(letter for letter in keyword if not letter.islower())
    raise ScpiError(f"'{text[:40]}' is none of {', '.join(keywords)}")


def number_between(text: str, lower: float, upper: float) -> float:
    """Return a number within bounds, in the unit that needs no name.

    Raises:
        ScpiError: It is none, or lies outside.
    """
    word = text.strip()
    if len(word) > LONGEST_NUMBER or not _NUMBER.fullmatch(word):
        raise ScpiError(f"'{text[:40]}' is not a number")
    if not lower <= float(word) <= upper:
        raise ScpiError(f"'{text[:40]}' is not between {lower:g} and {upper:g}")
    return float(word)


def whole_number_between(text: str, lower: int, upper: int) -> int:
    """Return a whole number within bounds; raises as `number_between` does."""
    value = number_between(text, lower, upper)
    if not value.is_integer():
        raise ScpiError(f"'{text[:40]}' is not a whole number")
    return int(value)


def switch(text: str) -> bool:
    """Return whether the text says ON or 1.

    Raises:
        ScpiError: It says neither that nor OFF or 0.
    """
    word = text.strip().upper()
    if word not in _SWITCH:
        raise ScpiError(f"'{text[:40]}' is none of {', '.join(_SWITCH)}")
    return _SWITCH[word]


def split_message(message: bytes) -> List[ScpiCommand]:
    """Return the commands of a message in their order.

    The first header may lack its colon. A later one must have it; the instrument does
    not know what to do with one that lacks it, so it is left out.
    """
    commands = []
    for place, part in enumerate(message.decode("latin-1").strip(" \t\r\n\0").split(";")):
        text = part.strip()
        if place == 0 and text[:1] not in (":", "*"):
            text = ":" + text
        if len(text) > 1 and text[0] in ":*":
            # "DATA?SDAT" has no blank between the question mark and its argument.
            header, *words = text.split(None, 1)
            before, question, after = header.partition("?")
            argument = " ".join(one for one in (after, *words) if one)
            commands.append(ScpiCommand(before, bool(question), argument.strip()))
    return commands
