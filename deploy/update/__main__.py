"""Update the robot's software from a stick, or return to the version before."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from pathlib import Path
from typing import NoReturn, TextIO

from gpr20_update.system import Paths, UpdateError, is_taken
from gpr20_update.update import Updater

RETURNED, REFUSED = 1, 2
EXIT_STATUS = (
    "exit status: 0 done, 1 the version before has returned because the doctor found a new FAULT "
    "or the installation failed, 2 refused or failed"
)
NO_SURVEY = "somebody has seen that no survey runs or is paused, although the nodes do not say so"


def main(root: str = "/") -> NoReturn:
    """Do what the arguments ask for; exit."""
    paths = Paths(Path(root))
    parser = argparse.ArgumentParser("gpr20-update", description=__doc__, epilog=EXIT_STATUS)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("stick", nargs="?", type=Path, help="folder of the stick")
    what.add_argument("--back", action="store_true", help="return to the version before")
    what.add_argument("--status", action="store_true", help="what is installed, how it went")
    what.add_argument(
        "--continue", action="store_true", dest="resume", help="end what a power cut interrupted"
    )
    parser.add_argument("--no-survey", action="store_true", help=NO_SURVEY)
    given = parser.parse_args()
    # A terminal that is closed and Ctrl-C do not end an installation halfway.
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        if os.geteuid() != 0:
            raise UpdateError("gpr20-update needs root; run: sudo gpr20-update ...")
        paths.state.mkdir(mode=0o700, exist_ok=True)
        paths.kept.mkdir(exist_ok=True)
        with (paths.state / "lock").open("ab") as lock:
            if not is_taken(lock):
                raise UpdateError("another gpr20-update is running; wait for its end")
            sys.exit(_do(given, Updater(paths, _say)))
    except (UpdateError, OSError) as error:
        _say(f"gpr20-update: {error}", sys.stderr)
        sys.exit(REFUSED)


def _do(given: argparse.Namespace, updater: Updater) -> int:
    if given.status:
        updater.status()
    elif given.back:
        updater.back(given.no_survey)
    elif given.resume:
        updater.resume(given.no_survey)
    else:
        return 0 if updater.update(given.stick, given.no_survey) else RETURNED
    return 0


def _say(sentence: str, file: TextIO = sys.stdout) -> None:
    # A text from outside, such as a name on a stick, can neither fake nor control the terminal.
    shown = "".join(
        one if one.isprintable() else one.encode("unicode_escape", "surrogatepass").decode("ascii")
        for one in sentence
    )
    try:
        print(shown, file=file, flush=True)
    except OSError:
        # The terminal is gone; the update is not.
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())


if __name__ == "__main__":
    main()
