"""Classes outside this repository that a robot's configuration names as `module:Class`."""

from __future__ import annotations

import importlib
import inspect
import re
from typing import Any, Mapping

from gpr20_common.errors import ConfigurationError
from gpr20_common.message import Message

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
    except Exception as error:  # the module is not ours: it may raise anything
        raise ConfigurationError(
            Message(
                "{key} is {name}, but {module} cannot be imported: {reason}; install its package "
                "in the virtual environment of this software, or correct the name",
                key=key,
                name=name,
                module=module,
                reason=f"{type(error).__name__}: {error}",
            )
        ) from error
    missing = [one for one in sorted(vars(protocol)) if one[0] != "_" and not hasattr(found, one)]
    if missing or not inspect.isclass(found):
        raise ConfigurationError(
            Message(
                "{key} is {name}, which is not usable as {protocol}: it lacks {missing}",
                key=key,
                name=name,
                protocol=protocol.__name__,
                missing=", ".join(missing) or "class",
            )
        )
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
