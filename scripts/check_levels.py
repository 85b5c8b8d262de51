"""Check that imports point downwards: high may use mid and low, mid low, and neither ROS.

Usage: check_levels.py FOLDER_OF_PACKAGES
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from typing import Iterator, List, Tuple

RANK = {"low": 0, "mid": 1, "high": 2}
# The analysis has folders by subject instead; none of them knows ROS.
SUBJECTS = ("read", "formats", "processing", "imaging", "plotting", "report")
RANK.update(dict.fromkeys(SUBJECTS, RANK["mid"]))
# What only the ROS interface may know.
ROS_MODULES = {"rospy", "actionlib", "tf2_ros", "diagnostic_updater", "genpy", "rosbag"}
# A bag is a file, so a low module may use what reads and writes it.
FILE_MODULES = {"genpy", "rosbag"}
ROS_SUFFIXES = ("_msgs", "_srvs")


def imported_names(source: Path) -> Iterator[Tuple[int, str]]:
    """Yield (line, module) of every import in a file."""
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.lineno, node.module


def complaints(source: Path, package: str, level: str) -> Iterator[str]:
    """Yield what is wrong with the imports of one file."""
    for line, module in imported_names(source):
        root = module.split(".")[0]
        known = FILE_MODULES if level == "low" else set()
        if level != "high" and (root in ROS_MODULES - known or root.endswith(ROS_SUFFIXES)):
            yield f"{source}:{line}: {level} level imports {module}; only high may know ROS"
        parts = module.split(".")
        if parts[0] == package and len(parts) > 1 and RANK.get(parts[1], -1) > RANK[level]:
            yield f"{source}:{line}: {level} level imports {module}; imports must point down"


def main(folder: Path) -> int:
    """Check all packages; return the exit status."""
    found: List[str] = []
    for level in RANK:
        for source in sorted(folder.glob(f"*/src/*/{level}/**/*.py")):
            package = source.relative_to(folder).parts[2]
            found.extend(complaints(source, package, level))
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
