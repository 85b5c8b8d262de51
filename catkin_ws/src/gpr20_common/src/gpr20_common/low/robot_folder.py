"""The folder of the robot's configuration, as commands that roslaunch does not start find it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Mapping

from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message

DEFAULT_FOLDER = "~/.gpr20/robot"


def robot_folder(environment: Mapping[str, str]) -> Path:
    """Return the folder that GPR20_CONFIG names, or the default; it need not exist."""
    return Path(environment.get("GPR20_CONFIG") or DEFAULT_FOLDER).expanduser().absolute()


def configured(path: Path) -> Dict[str, Any]:
    """Return the values in a file of the configuration; none without the file.

    Raises:
        OSError: The file cannot be read.
        YamlFileError: The file is damaged.
    """
    try:
        values = read_yaml(path)
    except FileNotFoundError:
        return {}
    except YamlFileError as error:
        raise YamlFileError(Message("{file}: {reason}", file=path, reason=error.message)) from error
    if values is None or isinstance(values, dict):
        return values or {}
    reason = Message("it must be lines of the form {example}", example="key: value")
    raise YamlFileError(Message("{file}: {reason}", file=path, reason=reason))
