"""Collects the rostests: each file `*.test` is one test, run by `rostest` in its own process."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any, Dict, Iterator, Optional
from xml.etree import ElementTree

import pytest

from pytest_gpr20.processes import Ended, run_limited
from pytest_gpr20.workspace import has_ros

OFF_SCREEN = "QT_QPA_PLATFORM"
# Far more than any of them takes: it ends what hangs.
LIMIT_S = 900.0
LINES_SHOWN = 120
TESTS = re.compile(r"^ \* TESTS: (\d+)", re.MULTILINE)
FAILED = re.compile(r"^\[(\S+)\]\[(?:FAILURE|ERROR)\]", re.MULTILINE)


class RostestError(Exception):
    """A rostest failed; the text says which tests, and shows the end of what was printed."""


class RostestItem(pytest.Item):
    """One rostest, with a master, logs and results of its own."""

    def runtest(self) -> None:
        """Run it.

        Raises:
            RostestError: A test failed, none ran, or the time limit ended it.
        """
        if not has_ros():
            pytest.skip("this Python has no ROS")
        limit_s = float(self.config.getini("rostest_limit_s"))
        folder = Path(tempfile.mkdtemp(prefix="gpr20_rostest_"))
        command = ["rostest", str(self.path)]
        ended = run_limited(command, self._environment(folder), limit_s, self.path.parent)
        found = problem(ended)
        if found:
            raise RostestError(f"{found}; logs are in {folder}\n{end_of(ended.printed)}")
        shutil.rmtree(folder)

    def repr_failure(self, excinfo: Any, style: Any = None) -> Any:
        """Show what rostest printed instead of this module's traceback."""
        if isinstance(excinfo.value, RostestError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> Any:
        """Name it by its file; a skip needs a line."""
        return self.path, 0, self.path.name

    @staticmethod
    def _environment(folder: Path) -> Dict[str, str]:
        own = {"ROS_HOME": folder, "ROS_LOG_DIR": folder / "log"}
        own["ROS_TEST_RESULTS_DIR"] = folder / "results"
        # Unit tests in this process draw off screen; a rostest chooses its screen itself.
        inherited = {name: value for name, value in os.environ.items() if name != OFF_SCREEN}
        return {**inherited, **{name: str(path) for name, path in own.items()}}


class RostestFile(pytest.File):
    """A file `*.test`."""

    def collect(self) -> Iterator[pytest.Item]:
        """Yield its only item."""
        item = RostestItem.from_parent(self, name="rostest")
        described = ElementTree.parse(self.path).getroot()
        needs = [str(one.get("value")) for one in described.iter("arg") if is_need(one)]
        item.add_marker(pytest.mark.needs(*needs))
        yield item


def is_need(argument: ElementTree.Element) -> bool:
    """Return whether an argument of a rostest names what it needs of the machine."""
    return argument.get("name") == "needs"


def problem(ended: Ended) -> Optional[str]:
    """Return what is wrong with how rostest ended; None if nothing is."""
    failed = ", ".join(sorted(set(FAILED.findall(ended.printed))))
    if ended.status is None:
        return "the time limit ended it"
    if ended.status != 0 or failed:
        return f"failed: {failed or f'rostest ended with status {ended.status}'}"
    return None if tests_in(ended) else "no test ran"


def tests_in(ended: Ended) -> int:
    """Return how many tests a rostest ran."""
    counted = TESTS.findall(ended.printed)
    return int(counted[-1]) if counted else 0


def end_of(printed: str) -> str:
    """Return the last lines of a text."""
    return "\n".join(printed.splitlines()[-LINES_SHOWN:])


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the time limit."""
    parser.addini("rostest_limit_s", "time limit of each rostest [s]", default=str(LIMIT_S))


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> Optional[RostestFile]:
    """Collect a rostest."""
    if file_path.suffix == ".test":
        return RostestFile.from_parent(parent, path=file_path)
    return None


def pytest_ignore_collect(collection_path: Path) -> Optional[bool]:
    """Leave the Python files beside rostests to rostest."""
    inside = collection_path.parent.name == "ros" and collection_path.suffix == ".py"
    return True if inside else None
