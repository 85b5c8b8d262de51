"""YAML files that people write by hand, or that something damaged; where those of a robot are."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Dict, Mapping, Union

import yaml

from gpr20_common import faults
from gpr20_common.errors import Gpr20Error
from gpr20_common.message import UNREADABLE, Message

# A scene or a profile has some kilobytes; what is far larger is something else.
MAX_BYTES = 1 << 20

# The reader of plain values raises whatever their conversion does: for the day 2026-13-45 a
# ValueError, for `!!timestamp x` an AttributeError. It calls itself for each level.
_REFUSED = (yaml.YAMLError, *UNREADABLE)
STRING_TAG = "tag:yaml.org,2002:str"
NUMBER_TAGS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
# In YAML 1.1 013 is 11, and 10:50 is 650; nobody means that who writes it.
_ODD_NUMBER = re.compile(r"[-+]?(0[0-9_]+|[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?)")


class YamlFileError(Gpr20Error, ValueError):
    """A file is no YAML, or larger or deeper than one of ours."""

    fault = faults.FILE_DAMAGED


def read_yaml(path: Union[str, Path], max_bytes: int = MAX_BYTES) -> Any:
    """Return what a YAML file holds: plain values, lists and mappings, never objects.

    Raises an OSError if it cannot be read, and a YamlFileError if it holds something else.
    """
    return parse_yaml(limited_bytes(path, max_bytes))


def limited_bytes(path: Union[str, Path], max_bytes: int = MAX_BYTES) -> bytes:
    """Return the content of a file, or raise a YamlFileError if it is longer."""
    with open(path, "rb") as stream:
        text = stream.read(max_bytes + 1)
    if len(text) > max_bytes:
        raise YamlFileError(Message("it is larger than {limit} bytes", limit=max_bytes))
    return text


def parse_yaml(text: Union[str, bytes]) -> Any:
    """Return what a text of YAML holds."""
    try:
        return yaml.load(text, Loader=_UniqueKeyLoader)  # noqa: S506 - a SafeLoader
    except YamlFileError:
        raise
    except _REFUSED as error:
        raise YamlFileError(Message("it is not YAML", details=error)) from error


class _UniqueKeyLoader(yaml.SafeLoader):
    """Refuses a key that is written twice, of which the stock loader keeps the last value."""

    def resolve(self, kind: Any, value: Any, implicit: Any) -> Any:
        tag = super().resolve(kind, value, implicit)
        odd = tag in NUMBER_TAGS and implicit[0] and _ODD_NUMBER.fullmatch(value)
        return STRING_TAG if odd else tag

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> Any:
        seen = set()
        for key in (one for one, _value in node.value if isinstance(one, yaml.ScalarNode)):
            if key.value in seen:
                raise YamlFileError(
                    Message(
                        "the key {key} is there twice, again in line {line}; remove one",
                        key=key.value[:64],
                        line=key.start_mark.line + 1,
                    )
                )
            seen.add(key.value)
        return super().construct_mapping(node, deep)


DEFAULT_FOLDER = "~/.gpr20/robot"


def data_folder(configured: str, environment: Mapping[str, str]) -> Path:
    """Return the folder of the surveys: the parameter `data`, `GPR20_DATA`, or ~/gpr20_data."""
    # The output of a command, which roslaunch accepts for a parameter, ends with a line feed.
    data = configured.strip() or environment.get("GPR20_DATA", "") or "~/gpr20_data"
    return Path(data).expanduser().absolute()


def state_folder(environment: Mapping[str, str]) -> Path:
    return Path(environment.get("GPR20_STATE", "") or "~/.gpr20").expanduser().absolute()


def robot_folder(environment: Mapping[str, str]) -> Path:
    return Path(environment.get("GPR20_CONFIG") or DEFAULT_FOLDER).expanduser().absolute()


def configured(path: Path) -> Dict[str, Any]:
    """Return the values in a file of the configuration, as `read_yaml`; none without the file."""
    try:
        values = read_yaml(path)
        if values is None or isinstance(values, dict):
            return values or {}
        raise YamlFileError(Message("it must be lines of the form {example}", example="key: value"))
    except FileNotFoundError:
        return {}
    except YamlFileError as error:
        raise YamlFileError(Message("{file}: {reason}", file=path, reason=error.message)) from error
