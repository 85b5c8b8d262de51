"""Checks of values that come from outside, and of classes that a configuration names.

Each returns what it allows, or raises an InvalidValueError that calls it by a name. A class outside
this repository is named as `module:Class`.
"""

from __future__ import annotations

import importlib
import inspect
import re
from ipaddress import IPv4Address
from typing import Any, Mapping, Union

from gpr20_common.errors import ConfigurationError, InvalidValueError
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


_NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*")


def is_extension(name: str) -> bool:
    return _NAME.fullmatch(name) is not None


def load_extension(
    key: str, name: str, protocol: type, arguments: int, options: Mapping[str, Any]
) -> type:
    """Import a class that fits a protocol and takes so many arguments and its options; or refuse.

    Nothing is made, and whatever else a configuration names is never called. Its key there is
    that of the class, and `{key}_options` that of the options.
    """
    module, _colon, class_name = name.partition(":")
    try:
        found = getattr(importlib.import_module(module), class_name)
        members = (one for one in sorted(vars(protocol)) if one[0] != "_")
        lacking = [one for one in members if not hasattr(found, one)]
        if lacking or not inspect.isclass(found):
            raise TypeError(f"it lacks {', '.join(lacking) or 'class'}")
    except Exception as error:  # the module is not ours: it may raise anything
        raise ConfigurationError(
            Message(
                "{key} is {name}, which cannot be imported or is no {protocol}: {reason}; install "
                "its package in the virtual environment of this software, or correct the name",
                key=key,
                name=name,
                protocol=protocol.__name__,
                reason=f"{type(error).__name__}: {error}",
            )
        ) from error
    try:
        inspect.signature(found).bind(*range(arguments), **options)
    except TypeError as error:
        raise options_refused(f"{key}_options", found, str(error)) from error
    return found


def options_refused(key: str, extension: type, reason: str) -> ConfigurationError:
    """Return the error of a class that cannot be made with the options of the configuration."""
    name = extension.__name__
    return ConfigurationError(
        Message("{key} do not suit {class_name}: {reason}", key=key, class_name=name, reason=reason)
    )
