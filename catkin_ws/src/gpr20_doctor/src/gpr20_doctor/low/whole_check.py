"""The check of the whole robot, by the program that creates and checks its configuration."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Optional, Tuple

from gpr20_common.message import Message
from gpr20_common.sent_message import received_message

PROGRAM = ("rosrun", "gpr20_launch", "robot_config", "check", "--json")
LIMIT_S = 20.0
# Correct, and not.
STATUSES = (0, 1)
UNREADABLE = "a problem that cannot be read; run robot_config check by hand"


def problems(
    folder: Optional[Path], data: Optional[Path], robot: str, part: str
) -> Tuple[Message, ...]:
    """Return what is wrong in the files of a configuration, each with its fault.

    Args:
        folder: Of the configuration; None: the default one.
        data: Folder of the surveys; None: as configured.
        robot: gpr20 or simulated.
        part: What runs on this computer: robot, server, or survey for both.

    Raises:
        OSError: The program is not there, or did not answer; the text says why.
        ValueError: Its answer was not understood.
    """
    command = [*PROGRAM, "--robot", robot, "--part", part]
    command += [] if data is None else ["--data", str(data)]
    command += [] if folder is None else [str(folder)]
    try:
        ended = subprocess.run(command, capture_output=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired as error:
        raise TimeoutError(f"no answer within {LIMIT_S:g} s") from error
    if ended.returncode not in STATUSES:
        said = ended.stderr.decode(errors="replace").strip().splitlines()
        raise OSError(said[-1] if said else f"{PROGRAM[2]} ended with {ended.returncode}")
    records = json.loads(ended.stdout.decode(errors="replace"))
    if not isinstance(records, list):
        raise ValueError(f"{PROGRAM[2]} answered no list")
    return tuple(received_message(UNREADABLE, json.dumps(one)) for one in records)
