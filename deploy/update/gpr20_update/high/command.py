"""Update the robot's software from a stick, return to the version before, back up, restore."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from pathlib import Path
from typing import NoReturn, TextIO

from gpr20_update.errors import UpdateError
from gpr20_update.high.update import Updater
from gpr20_update.low.paths import Paths
from gpr20_update.low.system import only_one, shown
from gpr20_update.mid.packages import Packages
from gpr20_update.mid.robot import Robot

RETURNED, REFUSED = 1, 2
EXIT_STATUS = (
    "exit status: 0 done, 1 the version before has returned because the doctor found a new FAULT "
    "or the installation failed, 2 refused or failed"
)


def main(root: str = "/") -> NoReturn:
    """Do what the arguments ask for; exit. The program is one file with this function."""
    sys.exit(_run(Paths(Path(root))))


def _run(paths: Paths) -> int:
    parser = argparse.ArgumentParser("gpr20-update", description=__doc__, epilog=EXIT_STATUS)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("stick", nargs="?", type=Path, help="folder of the stick, or of its bundle")
    what.add_argument("--back", action="store_true", help="return to the version before")
    what.add_argument("--status", action="store_true", help="what is installed, how it went")
    what.add_argument("--backup", type=Path, metavar="FILE", help="write the configuration there")
    what.add_argument("--restore", type=Path, metavar="FILE", help="take it from there")
    what.add_argument(
        "--continue", action="store_true", dest="resume", help="end what a power cut interrupted"
    )
    parser.add_argument(
        "--no-survey",
        action="store_true",
        help="somebody has seen that no survey runs or is paused, although the nodes do not say so",
    )
    given = parser.parse_args()
    # A terminal that is closed and Ctrl-C do not end an installation halfway.
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        if os.geteuid() != 0:
            raise UpdateError("gpr20-update needs root; run: sudo gpr20-update ...")
        paths.state.mkdir(mode=0o700, exist_ok=True)
        with only_one(paths.state / "lock"):
            paths.kept.mkdir(exist_ok=True)
            return _do(given, Updater(paths, Packages(paths), Robot(paths), _say))
    except (UpdateError, OSError) as error:
        _say(f"gpr20-update: {shown(error)}", sys.stderr)
        return REFUSED


def _do(given: argparse.Namespace, updater: Updater) -> int:
    if given.status:
        updater.status()
    elif given.back:
        updater.back(given.no_survey)
    elif given.resume:
        updater.resume(given.no_survey)
    elif given.backup:
        updater.backup(given.backup)
    elif given.restore:
        updater.restore(given.restore, given.no_survey)
    else:
        return 0 if updater.update(given.stick, given.no_survey) else RETURNED
    return 0


def _say(sentence: str, file: TextIO = sys.stdout) -> None:
    try:
        print(sentence, file=file, flush=True)
    except OSError:
        # The terminal is gone; the update is not.
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())
