"""Finds what is wrong with a robot and with this computer; here the arguments of the program."""

from __future__ import annotations

import argparse
import math
import os
from pathlib import Path

DEFAULT_WAIT_S = 4.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--quick", action="store_true", help="without the test of the VNA")
    parser.add_argument(
        "--wait",
        type=_seconds,
        default=DEFAULT_WAIT_S,
        metavar="S",
        help="wait at most this long until every part of the robot has reported [s]; default "
        f"{DEFAULT_WAIT_S:g}",
    )
    parser.add_argument(
        "--ns", default=os.environ.get("ROS_NAMESPACE", ""), help="namespace of the robot"
    )
    parser.add_argument(
        "--bundle",
        type=_new_bundle,
        metavar="FILE.json",
        help="also write one file for remote help: findings, versions, settings, errors",
    )


def _seconds(text: str) -> float:
    if not 0.0 <= float(text) < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is no time; allowed: 0 or more seconds")
    return float(text)


def _new_bundle(text: str) -> Path:
    if not text.endswith(".json"):
        raise argparse.ArgumentTypeError(f"{text} is no FILE.json: a bundle is JSON")
    if os.path.lexists(text):
        raise argparse.ArgumentTypeError(f"{text} exists; choose another name")
    return Path(text)
