"""Long tests first, so that no worker of pytest-xdist is left with one at the end.

The marker `takes(seconds)` says about how long a test takes on an idle machine. The tests of a file
run in one worker and share its fixtures, unless the setting `separate_tests` names the file.
"""

from __future__ import annotations

from typing import Any, Dict, Iterator, List, Sequence

import pytest

MARKER = "takes(seconds): about how long the test takes on an idle machine"
SETTING = "separate_tests"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the setting."""
    parser.addini(SETTING, "files whose tests run in any worker", type="linelist", default=[])


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker."""
    config.addinivalue_line("markers", MARKER)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: List[pytest.Item]) -> None:
    """Sort the groups by their longest tests, the longest first."""
    separate = config.getini(SETTING)
    longest: Dict[str, float] = {}
    for item in items:
        group = group_of(item.nodeid, separate)
        longest[group] = max(longest.get(group, 0.0), seconds_of(item))
    items.sort(key=lambda item: -longest[group_of(item.nodeid, separate)])


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give the groups to the workers in the order of the tests."""
    from pytest_gpr20.scheduler import InOrder

    separate = config.getini(SETTING)
    return InOrder(config, log, lambda nodeid: group_of(nodeid, separate))


@pytest.hookimpl(hookwrapper=True, optionalhook=True)
def pytest_handlecrashitem(report: Any) -> Iterator[None]:
    """Count a test that a worker died in as failed: pytest-rerunfailures would repeat it."""
    yield
    report.outcome = "failed"


def seconds_of(item: pytest.Item) -> float:
    """Return about how long a test takes [s]; 0 if nobody has said so."""
    marker = item.get_closest_marker("takes")
    return float(marker.args[0]) if marker else 0.0


def group_of(nodeid: str, separate: Sequence[str]) -> str:
    """Return the name of the tests that run in the same worker as this one: a file or itself."""
    file = nodeid.split("::", 1)[0]
    return nodeid if file in separate else file
