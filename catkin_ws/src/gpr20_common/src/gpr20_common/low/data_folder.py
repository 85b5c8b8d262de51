"""Where a robot stores its surveys, what this user's programs remember, and its configuration."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Mapping

from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message

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
