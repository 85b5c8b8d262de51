"""The command gpr20-verify: check a survey's folder, without ROS."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import List, Optional

from gpr20_analysis.mid.verification import verify
from gpr20_common.errors import Gpr20Error

NO_SURVEY = 3
FAULTS_TOLD = 50


def main(arguments: Optional[List[str]] = None) -> int:
    """Check the folder that is named; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="gpr20-verify",
        description="Check a survey's folder: files, numbers, places. Nothing is changed.",
        epilog="exit status: 0 complete and intact, 1 intact but not complete, 2 damaged or "
        "contradictory, 3 no survey",
    )
    parser.add_argument("folder", type=Path, help="folder of one survey")
    parser.add_argument("--all", action="store_true", help=f"tell more than {FAULTS_TOLD} faults")
    try:
        chosen = parser.parse_args(arguments)
    except SystemExit as ending:
        return NO_SURVEY if ending.code else 0
    try:
        found = verify(chosen.folder)
    except (Gpr20Error, OSError) as error:
        print(f"gpr20-verify: {error}", file=sys.stderr)
        return NO_SURVEY
    told = found.faults if chosen.all else found.faults[:FAULTS_TOLD]
    for fault in told:
        print(f"FAULT: {fault}")
    if len(told) < len(found.faults):
        print(f"... and {len(found.faults) - len(told)} more; --all tells them")
    for note in found.notes:
        print(f"note: {note}")
    print(found.verdict)
    return found.status


if __name__ == "__main__":
    sys.exit(main())
