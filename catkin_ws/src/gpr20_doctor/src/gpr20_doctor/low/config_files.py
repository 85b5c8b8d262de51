"""Single values of the robot's configuration, as far as they can be read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.yaml_file import read_yaml


def configured(folder: Path, file: str, key: str) -> Any:
    """Return a value of a file; None if it is not there or the launch would refuse the file."""
    try:
        values = read_yaml(folder / file)
    except (OSError, Gpr20Error):
        return None
    return values.get(key) if isinstance(values, dict) else None
