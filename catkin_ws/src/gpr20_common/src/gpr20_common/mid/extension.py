"""Classes outside this repository that a robot's configuration names as `module:Class`."""

from __future__ import annotations

import importlib
import inspect
import re
from typing import Any, List, Mapping

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message

_NAME = re.compile(r"([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*):([A-Za-z_]\w*)")
NAME_LENGTH = 200


def is_extension(name: str) -> bool:
    """Return whether a name has the form `module:Class`."""
    return len(name) <= NAME_LENGTH and _NAME.fullmatch(name) is not None


def load_extension(key: str, name: str, protocol: type) -> type:
    """Import a class and check that it has the methods and properties of a protocol.

    The check comes before any use: whatever else a configuration names is never called.

    Args:
        key: Key of the configuration that names it, for the messages.
        name: The class, as `module:Class`.
        protocol: What it must implement.

    Raises:
        InvalidValueError: It cannot be imported, or does not implement the protocol.
    """
    match = _NAME.fullmatch(name) if len(name) <= NAME_LENGTH else None
    if match is None:
        raise InvalidValueError(
            Message(
                "{key} is {name}; it must have the form {example}",
                key=key,
                name=repr(name[:NAME_LENGTH]),
                example="package.module:Class",
            ),
            fault=faults.EXTENSION_UNUSABLE,
        )
    module_name, class_name = match.groups()
    try:
        found = getattr(importlib.import_module(module_name), class_name, None)
    except Exception as error:  # the module is not ours: it may raise anything
        raise InvalidValueError(
            Message(
                "{key} is {name}, but {module} cannot be imported: {reason}; install its package "
                "in the virtual environment of this software, or correct the name",
                key=key,
                name=name,
                module=module_name,
                reason=f"{type(error).__name__}: {error}",
            ),
            fault=faults.EXTENSION_UNUSABLE,
        ) from error
    if not inspect.isclass(found):
        raise InvalidValueError(
            Message(
                "{key} is {name}, but {module} has no class {class_name}",
                key=key,
                name=name,
                module=module_name,
                class_name=class_name,
            ),
            fault=faults.EXTENSION_UNUSABLE,
        )
    missing = [one for one in _members(protocol) if not hasattr(found, one)]
    if missing:
        raise InvalidValueError(
            Message(
                "{key} is {name}, which is not usable as {protocol}: it lacks {missing}",
                key=key,
                name=name,
                protocol=protocol.__name__,
                missing=", ".join(missing),
            ),
            fault=faults.EXTENSION_UNUSABLE,
        )
    return found


def check_options(key: str, extension: type, arguments: int, options: Mapping[str, Any]) -> None:
    """Check that a class can be made with these options; nothing is made.

    Args:
        key: Key of the configuration that holds the options.
        extension: The class.
        arguments: How many arguments come before the options.
        options: The options of the configuration.

    Raises:
        InvalidValueError: One is missing or unknown.
    """
    try:
        inspect.signature(extension).bind(*range(arguments), **options)
    except TypeError as error:
        raise options_refused(key, extension, str(error)) from error


def options_refused(key: str, extension: type, reason: str) -> InvalidValueError:
    """Return the error of a class that cannot be made with the options of the configuration."""
    return InvalidValueError(
        Message(
            "{key} do not suit {class_name}: {reason}",
            key=key,
            class_name=extension.__name__,
            reason=reason,
        ),
        fault=faults.EXTENSION_UNUSABLE,
    )


def _members(protocol: type) -> List[str]:
    return sorted(name for name in vars(protocol) if not name.startswith("_"))
