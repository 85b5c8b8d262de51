"""The arguments of the doctor."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from gpr20_doctor.mid.machine_request import AUTOMATIC, REAL, SIMULATED

DEFAULT_WAIT_S = 4.0
LONGEST_WAIT_S = 600.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="without what takes longer: speed of the disk, chrony, tests of VNA and height",
    )
    parser.add_argument(
        "--wait",
        type=_seconds,
        default=DEFAULT_WAIT_S,
        metavar="S",
        help="wait at most this long until every part of the robot has reported [s]; default "
        f"{DEFAULT_WAIT_S:g}",
    )
    parser.add_argument(
        "--robot",
        choices=(AUTOMATIC, REAL, SIMULATED),
        default=AUTOMATIC,
        help="whether to check hardware; auto: as the robot that runs, else on a Raspberry Pi",
    )
    parser.add_argument(
        "--ns", default=os.environ.get("ROS_NAMESPACE", ""), help="namespace of the robot"
    )
    parser.add_argument(
        "--config", type=named_folder, help="folder of the robot's configuration, if no robot runs"
    )
    parser.add_argument(
        "--bundle",
        type=_new_file,
        metavar="FILE.zip",
        help="also write one file for remote help: findings, logs, configuration without secrets",
    )


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0.0 <= seconds <= LONGEST_WAIT_S:
        raise argparse.ArgumentTypeError(f"give 0 to {LONGEST_WAIT_S:g} s")
    return seconds


def _new_file(text: str) -> Path:
    path = Path(text).expanduser()
    if path.exists():
        raise argparse.ArgumentTypeError(f"{path} exists; give the name of a new file")
    if not path.absolute().parent.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {path.absolute().parent}")
    return path


def named_folder(text: str) -> Path:
    """Return a folder that is an argument: none at all, as of an unset variable, is refused."""
    if not text.strip():
        raise argparse.ArgumentTypeError("name a folder")
    return Path(text)
