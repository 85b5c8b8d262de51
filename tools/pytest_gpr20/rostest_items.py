"""Collects the rostests: each file `*.test` is one test, run by `rostest` in its own process."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Iterator, Optional
from xml.etree import ElementTree

import pytest

# Beside the time limits of the tests in it: what a launch takes to begin and to end.
LAUNCH_LIMIT_S = 240.0
LINES_SHOWN = 120
TESTS = re.compile(r"^ \* TESTS: (\d+)", re.MULTILINE)
FAILED = re.compile(r"^\[(\S+)\]\[(?:FAILURE|ERROR)\]", re.MULTILINE)


class RostestItem(pytest.Item):
    """One rostest, with a master, logs and results of its own."""

    def runtest(self) -> None:
        """Run it; if a test fails or none runs, show which, and the end of what was printed."""
        pytest.importorskip("rospy", reason="this Python has no ROS")
        folder = Path(tempfile.mkdtemp(prefix="gpr20_rostest_"))
        own = {"ROS_HOME": folder, "ROS_LOG_DIR": folder / "log"}
        own["ROS_TEST_RESULTS_DIR"] = folder / "results"
        environment = {**os.environ, **{name: str(path) for name, path in own.items()}}
        # Unit tests in this process draw off screen; a rostest chooses its screen itself.
        environment.pop("QT_QPA_PLATFORM", None)
        ended = subprocess.run(
            ["rostest", str(self.path)],
            cwd=self.path.parent,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        failed = ", ".join(sorted(set(FAILED.findall(ended.stdout))))
        counted = TESTS.findall(ended.stdout)
        found = "" if counted and int(counted[-1]) else "no test ran"
        if ended.returncode != 0 or failed:
            found = f"failed: {failed or f'rostest ended with status {ended.returncode}'}"
        if found:
            end = "\n".join(ended.stdout.splitlines()[-LINES_SHOWN:])
            pytest.fail(f"{found}; logs are in {folder}\n{end}", pytrace=False)
        shutil.rmtree(folder)

    def reportinfo(self) -> Any:
        """Name it by its file; a skip needs a line."""
        return self.path, 0, self.path.name


class RostestFile(pytest.File):
    """A file `*.test`."""

    def collect(self) -> Iterator[pytest.Item]:
        """Yield its only item."""
        item = RostestItem.from_parent(self, name="rostest")
        tests = ElementTree.parse(self.path).getroot().iter("test")
        limit_s = LAUNCH_LIMIT_S + sum(float(one.get("time-limit", 60)) for one in tests)
        item.add_marker(pytest.mark.timeout(limit_s))
        yield item


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> Optional[RostestFile]:
    """Collect a rostest."""
    if file_path.suffix == ".test":
        return RostestFile.from_parent(parent, path=file_path)
    return None


def pytest_ignore_collect(collection_path: Path) -> Optional[bool]:
    """Leave the Python files beside rostests to rostest."""
    inside = collection_path.parent.name == "ros" and collection_path.suffix == ".py"
    return True if inside else None
