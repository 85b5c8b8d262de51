"""Decimal numbers as people write them, with a point or with a comma."""

from __future__ import annotations

import re
from decimal import Decimal

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message

# Not Decimal() or float() alone: they accept digits of other scripts, underscores and words.
_NUMBER = re.compile(r"[-+]?([0-9]{1,20}([.,][0-9]{0,20})?|[.,][0-9]{1,20})([eE][-+]?[0-9]{1,3})?")
SHOWN_CHARACTERS = 64


def decimal_from_text(text: str) -> Decimal:
    """Return the number of a text such as "12.5" or "12,5", exactly.

    Numbers are shown with a point in every language, as the VNA and the files have them.

    Raises:
        InvalidValueError: The text is not a number.
    """
    number = text.strip()
    if not _NUMBER.fullmatch(number):
        raise InvalidValueError(Message("'{text}' is not a number", text=text[:SHOWN_CHARACTERS]))
    return Decimal(number.replace(",", "."))


def number_from_text(text: str) -> float:
    """Return the number of a text such as "12.5" or "12,5".

    Raises:
        InvalidValueError: The text is not a number.
    """
    return float(decimal_from_text(text))


def plain_text(value: Decimal) -> str:
    """Return a number without an exponent and without zeros at its end."""
    text = f"{value:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
