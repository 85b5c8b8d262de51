"""Make groups of pictures; started by scripts/pictures.sh."""

from __future__ import annotations

import argparse
import importlib
import multiprocessing
from pathlib import Path

DOCS_IMAGES = Path(__file__).resolve().parents[2] / "docs/images"
# What each module makes, for the documentation.
GROUPS = {
    "architecture": "ROS graph, states and frames, from the text of the pages that show them",
    "animation": "the sample survey, from the first stop to the image",
    "real_line": "the image of the real line",
    "report": "two pages of a report of the sample survey",
    "hiding": "where a mine could hide in the sample survey",
    "window": "every tab of the window during a survey, in 800x480",
    "candidates": "the candidates of a survey in the window",
    "replay": "the window during a replay",
    "view": "gpr20 view of the sample survey",
}
# To look at, in a folder of their own.
CHECKS = {
    "moments": "the window 1, 5 and 30 s after twelve faults, and a table of what it says",
}
ALL = {**GROUPS, **{name: f"{what} (needs --into)" for name, what in CHECKS.items()}}


def make(name: str, folder: Path) -> None:
    """Make one group of pictures."""
    importlib.import_module(f"pictures.{name}").make(folder)


def main() -> None:
    """Make the groups that are named, or list all."""
    parser = argparse.ArgumentParser(
        prog="scripts/pictures.sh",
        description="\n".join(f"  {name:13} {what}" for name, what in ALL.items()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--into", type=Path, metavar="FOLDER", help="instead of docs/images")
    parser.add_argument("names", nargs="*", metavar="NAME", help="what is made, from the list")
    chosen = parser.parse_args()
    if not chosen.names:
        parser.print_help()
    for name in chosen.names:
        if name not in ALL:
            parser.error(f"there is no {name}; without a name all are listed")
        if name in CHECKS and chosen.into is None:
            parser.error(f"{name} is not for docs/images; give --into FOLDER")
    folder = (chosen.into or DOCS_IMAGES).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for name in chosen.names:
        # A process can be a ROS node, and a Qt application, only once.
        process = multiprocessing.Process(target=make, args=(name, folder))
        process.start()
        process.join()
        if process.exitcode:
            raise SystemExit(f"{name}: the pictures were not made")


if __name__ == "__main__":
    main()
