"""The last line of a run counts its tests.

Before it: the numbers of tests inside those that run others (the property `INSIDE`), and the
coverage of each package if pytest-cov has measured it.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any, Dict, List, Tuple

import pytest

# Outcomes of pytest's terminal reporter; the first are counted even if there are none.
ALWAYS = ("passed", "failed", "skipped", "rerun")
OTHERWISE = ("error", "xfailed", "xpassed")
INSIDE = "tests inside"


class LastLine:
    """Names a worker's failed test at once, and prints the counts after everything else.

    Args:
        reporter: The terminal reporter of pytest.
    """

    def __init__(self, reporter: Any) -> None:
        self._reporter = reporter

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Name a test of a worker that failed or will be repeated; the details come at the end."""
        if hasattr(report, "node") and report.outcome not in ("passed", "skipped"):
            self._reporter.ensure_newline()
            self._reporter.write_line(f"{report.nodeid} {report.outcome} in {report.when}")

    @pytest.hookimpl(trylast=True)
    def pytest_unconfigure(self) -> None:
        """Print the last line."""
        self._reporter.write_line(counted(self._reporter.stats))


def counted(stats: Dict[str, List[Any]]) -> str:
    """Return the counts of a run, with the reasons of skipped and the names of repeated tests.

    Args:
        stats: The reports by outcome, as the terminal reporter keeps them.
    """
    notes = {
        "skipped": Counter(reason_of(one) for one in stats.get("skipped", [])),
        "rerun": Counter(one.nodeid for one in stats.get("rerun", [])),
    }
    parts = []
    for outcome in (*ALWAYS, *OTHERWISE):
        number = len(stats.get(outcome, []))
        if number or outcome in ALWAYS:
            parts.append(f"{number} {outcome}{in_short(notes.get(outcome, Counter()))}")
    return ", ".join(parts)


def in_short(notes: Counter) -> str:
    """Return notes in parentheses, the most frequent first, each with how often it occurred."""
    if not notes:
        return ""
    ordered = sorted(notes.items(), key=lambda one: (-one[1], one[0]))
    return f" ({'; '.join(f'{number} x {note}' for note, number in ordered)})"


def reason_of(report: Any) -> str:
    """Return why a test was skipped, in one line."""
    _file, _line, reason = report.longrepr
    return " ".join(str(reason).replace("Skipped: ", "", 1).split())


def coverage_by_package(measured: Any) -> Dict[str, Tuple[int, int]]:
    """Return the numbers of statements and of those that ran, by package.

    Args:
        measured: The data of pytest-cov, as an object `coverage.Coverage`.
    """
    packages: Dict[str, Tuple[int, int]] = {}
    for file in sorted(measured.get_data().measured_files()):
        _name, statements, _excluded, missing, _text = measured.analysis2(file)
        package = package_of(Path(file))
        all_statements, ran = packages.get(package, (0, 0))
        ran += len(statements) - len(missing)
        packages[package] = (all_statements + len(statements), ran)
    return packages


def package_of(file: Path) -> str:
    """Return the package of a source file: the folder after `src`."""
    parts = file.parts
    return parts[len(parts) - parts[::-1].index("src")]


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    """Print the last line after all that other plugins print."""
    reporter = config.pluginmanager.getplugin("terminalreporter")
    if reporter and not hasattr(config, "workerinput") and not config.option.collectonly:
        config.pluginmanager.register(LastLine(reporter))


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Show the tests inside tests, and the coverage of each package."""
    show_inside(terminalreporter)
    show_coverage(terminalreporter, config)


def show_inside(reporter: Any) -> None:
    """Show the tests that run others, how long they took and how many tests they ran."""
    reports = [*reporter.stats.get("passed", []), *reporter.stats.get("failed", [])]
    # A repeated test notes the property at each try; the last one counts.
    inside = [(one, dict(getattr(one, "user_properties", ())).get(INSIDE)) for one in reports]
    found = [f"{one.duration:5.0f} s  {one.nodeid}: {value}" for one, value in inside if value]
    if found:
        reporter.section("tests inside tests")
        for line in sorted(found, reverse=True):
            reporter.write_line(line)


def show_coverage(reporter: Any, config: pytest.Config) -> None:
    """Show the coverage of each package if pytest-cov has measured it."""
    plugin = config.pluginmanager.getplugin("_cov")
    if not plugin or not getattr(plugin, "cov_controller", None):
        return
    packages = coverage_by_package(plugin.cov_controller.cov)
    reporter.section("coverage by the unit tests (rostests are not measured)")
    total = (sum(one[0] for one in packages.values()), sum(one[1] for one in packages.values()))
    for name, (statements, ran) in [*packages.items(), ("all", total)]:
        share = 100.0 * ran / statements if statements else 100.0
        reporter.write_line(f"{name:24}{statements:7} statements {share:5.1f} %")
