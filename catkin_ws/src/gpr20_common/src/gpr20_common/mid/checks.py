"""Checks of values that come from outside.

Each returns the value, or raises an InvalidValueError that calls it by a name.
"""

from __future__ import annotations

from ipaddress import IPv4Address
from typing import Union

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, numeral, verbatim

Text = Union[str, Message]
# Far longer than any address of an instrument.
MAX_ADDRESS_CHARACTERS = 128


def number_between(name: Text, value: float, lower: float, upper: float, unit: Text = "") -> float:
    """Allow what lies within the bounds [unit], both included."""
    # Written so that NaN, which fails every comparison, is refused too.
    if not lower <= value <= upper:
        raise InvalidValueError(
            Message(
                "{name} is {value}; it must lie between {lower} and {upper}",
                name=name,
                value=with_unit(value, unit),
                lower=numeral(lower, ".12g"),
                upper=with_unit(upper, unit),
            )
        )
    return value


def ipv4_address(name: Text, address: str) -> str:
    """Allow four decimal numbers of 0 to 255."""
    try:
        plain = str(IPv4Address(address)) == address  # 010 is 8 to some readers
    except ValueError:
        plain = False
    if not plain:
        raise InvalidValueError(
            Message(
                "{name} is '{address}'; it must be four numbers of 0 to 255, such as 192.168.1.10",
                name=name,
                address=address[:64],
            )
        )
    return address


def instrument_address(name: Text, address: str) -> str:
    """Allow four numbers, or what "::" sets apart from them: the instrument's driver checks it."""
    if "::" not in address:
        return ipv4_address(name, address)
    printable = address.isascii() and address.isprintable() and " " not in address
    if not printable or len(address) > MAX_ADDRESS_CHARACTERS:
        raise InvalidValueError(
            Message(
                "{name} is '{address}'; it must have at most {most} characters, without spaces "
                "and accents",
                name=name,
                address=address[:64],
                most=MAX_ADDRESS_CHARACTERS,
            )
        )
    return address


def with_unit(number: float, unit: Text) -> Message:
    """Return a number and what it is counted in; empty: it is counted in nothing."""
    try:
        shown = numeral(number, ".12g")
    except OverflowError:
        # A whole number from a file may have hundreds of digits.
        shown = verbatim("inf" if number > 0 else "-inf")
    return Message("{number} {unit}", number=shown, unit=unit) if unit else shown
