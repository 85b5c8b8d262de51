"""Programs of this computer that are asked, such as chrony and the check of the configuration."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any, Mapping, NamedTuple, Optional, Sequence, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.yaml_file import read_yaml
from gpr20_common.message import Message
from gpr20_common.sent_message import received_message

TRACKING = ("chronyc", "-c", "tracking")
# Columns of its answer: the offset of the clock [s], and the leap status.
OFFSET, LEAP = 4, 13
UNSYNCHRONIZED = "Not synchronised"
# Of a program that has nothing to do but to say what it knows, on a busy computer.
ANSWER_LIMIT_S = 10.0
CHECK = ("rosrun", "gpr20_launch", "robot_config", "check", "--json")
CHECK_LIMIT_S = 60.0
# Nothing is wrong, and something is.
CHECK_STATUSES = (0, 1)
UNREADABLE = "a problem that cannot be read; run robot_config check by hand"


def answer_of(
    command: Sequence[str],
    limit_s: float,
    statuses: Optional[Sequence[int]] = (0,),
    environment: Optional[Mapping[str, str]] = None,
) -> str:
    """Return what a program prints.

    Args:
        command: The program and its arguments.
        limit_s: Within which it must end [s].
        statuses: Exit statuses of an answer; None: whatever prints something is one.
        environment: Variables beside those of this process.

    Raises:
        FileNotFoundError: It is not installed.
        OSError: It failed or was late; the text says why.
    """
    path = shutil.which(command[0])
    if path is None:
        raise FileNotFoundError(f"{command[0]} is not installed")
    try:
        ended = subprocess.run(
            [path, *command[1:]],
            capture_output=True,
            timeout=limit_s,
            env={**os.environ, **(environment or {})},
        )
    except subprocess.TimeoutExpired as error:
        raise TimeoutError(f"{command[0]} did not end within {limit_s:g} s") from error
    answer = ended.stdout.decode(errors="replace")
    if not answer.strip() if statuses is None else ended.returncode not in statuses:
        said = ended.stderr.decode(errors="replace").strip().splitlines()
        raise OSError(said[-1] if said else f"{command[0]} ended with {ended.returncode}")
    return answer


class Tracking(NamedTuple):
    """The clock of this computer: whether it follows a source, and its offset [s]."""

    synchronized: bool
    offset_s: float


def tracking() -> Tracking:
    """Return what chrony says of the clock.

    Raises:
        OSError: chrony is not there, or did not answer in time.
        ValueError: Its answer was not understood.
    """
    answer = answer_of(TRACKING, ANSWER_LIMIT_S)
    fields = answer.strip().split(",")
    if len(fields) <= LEAP:
        raise ValueError(f"chronyc answered {answer[:80]!r}")
    return Tracking(fields[LEAP] != UNSYNCHRONIZED, float(fields[OFFSET]))


def problems(
    folder: Path, data: str, robot: str, part: str, environment: Mapping[str, str]
) -> Tuple[Message, ...]:
    """Return what is wrong in the files of a configuration, each with its fault.

    Args:
        folder: Of the configuration.
        data: Folder of the surveys that the launch was given; empty: as configured.
        robot: The robot that uses it: gpr20 or simulated.
        part: What runs on this computer: robot, server, or survey for both.
        environment: The variables, with those of the services.

    Raises:
        OSError: The program is not there, or did not answer; the text says why.
        ValueError: Its answer was not understood.
    """
    command = [*CHECK, "--robot", robot, "--part", part, "--data", data, str(folder)]
    records = json.loads(answer_of(command, CHECK_LIMIT_S, CHECK_STATUSES, environment))
    if not isinstance(records, list):
        raise ValueError("robot_config answered no list")
    return tuple(received_message(UNREADABLE, one) for one in records)


def configured(folder: Path, file: str, key: str) -> Any:
    """Return a value of a configuration file; None if it is not there or cannot be read."""
    try:
        values = read_yaml(folder / file)
    except (OSError, Gpr20Error):
        return None
    return values.get(key) if isinstance(values, dict) else None
