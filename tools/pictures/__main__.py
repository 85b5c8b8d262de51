"""Make groups of pictures; started by scripts/pictures.sh."""

from __future__ import annotations

import argparse
import importlib
import multiprocessing
from pathlib import Path

DOCS_IMAGES = Path(__file__).resolve().parents[2] / "docs/images"
# Module and function of each group, and what it makes.
GROUPS = {
    "animation": ("analysis", "the image of the sample survey, line by line"),
    "real_line": ("analysis", "the image of the real line"),
    "report": ("analysis", "a report of the sample survey"),
    "hiding": ("analysis", "where a mine could hide in the sample survey"),
    "window": ("windows", "every tab of the window during a survey, in 800x480"),
    "candidates": ("windows", "the candidates of a survey in the window"),
    "replay": ("windows", "the window during a replay"),
    "view": ("windows", "gpr20 view of the sample survey"),
}


def make(name: str, folder: Path) -> None:
    """Make one group of pictures."""
    module = importlib.import_module(f"pictures.{GROUPS[name][0]}")
    getattr(module, name)(folder)


def main() -> None:
    """Make the groups that are named, or list all."""
    parser = argparse.ArgumentParser(
        prog="scripts/pictures.sh",
        description="\n".join(f"  {name:13} {what}" for name, (_, what) in GROUPS.items()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--into", type=Path, metavar="FOLDER", default=DOCS_IMAGES)
    parser.add_argument("names", nargs="*", metavar="NAME", help="what is made, from the list")
    chosen = parser.parse_args()
    if not chosen.names or not GROUPS.keys() >= set(chosen.names):
        parser.print_help()
        raise SystemExit(2 if chosen.names else 0)
    folder = chosen.into.resolve()
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
