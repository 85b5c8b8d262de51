"""Where a robot stores its surveys, and where this user's programs remember something."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping


def data_folder(configured: str, environment: Mapping[str, str]) -> Path:
    """Return the folder of the surveys, as an absolute path.

    Args:
        configured: The parameter `data`; empty: `GPR20_DATA`, or ~/gpr20_data if that is not set.
        environment: The variables of the process.
    """
    # The output of a command, which roslaunch accepts for a parameter, ends with a line feed.
    data = configured.strip() or environment.get("GPR20_DATA", "") or "~/gpr20_data"
    return Path(data).expanduser().absolute()


def state_folder(environment: Mapping[str, str]) -> Path:
    """Return the folder of what is remembered on this computer, as an absolute path.

    Args:
        environment: The variables of the process: `GPR20_STATE`, or ~/.gpr20 if that is not set.
    """
    return Path(environment.get("GPR20_STATE", "") or "~/.gpr20").expanduser().absolute()
