"""The rules of the sources: the lint, the size of each part, imports, sentences."""

from __future__ import annotations

import re

import pytest
from house import complaints, limits, lines_by_part
from translations import module_files, shown_files
from user_shell import ROOT, printed_by
from wings_kit import NEEDS_ALL

SOURCES = sorted(
    [*ROOT.glob("catkin_ws/src/*/src/*/__init__.py"), *ROOT.glob("deploy/*/*/__init__.py")],
    key=lambda one: one.parent.name,
)


@NEEDS_ALL
@pytest.mark.timeout(450)
def test_the_lint_finds_nothing():
    printed_by(ROOT / "scripts/lint.sh")


def test_no_part_is_larger_than_its_limit_in_pyproject():
    assert complaints(lines_by_part(ROOT), limits(ROOT)) == []


@NEEDS_ALL
def test_every_package_is_covered_by_the_contracts_on_imports():
    contracts = (ROOT / "pyproject.toml").read_text()
    roots = contracts.split("root_packages = [")[1].split("]")[0]
    assert re.findall(r'"(\w+)"', roots) == [one.parent.name for one in SOURCES]


@NEEDS_ALL
def test_what_reaches_operators_is_translated_and_what_only_commands_say_is_not():
    files, shown = module_files(), shown_files()
    is_shown = {name: path in shown for name, path in files.items()}
    # Programs, what they import, a child process, what that takes of the public interface, what
    # is imported by its name, a driver that a file names, and who answers the window.
    for name in (
        *("gpr20_user_interface.window.rail", "gpr20_main_control.faults"),
        *("gpr20_common.errors", "gpr20_doctor.high.doctor"),
        *("gpr20_imaging.low.analysis_worker", "gpr20_analysis.read.load"),
        "gpr20_scikit_rf.low.visa_link",
        "gpr20_analysis.high.replay_node",
    ):
        assert is_shown[name], name
    for name in (
        *("gpr20_analysis.commands.file_commands", "gpr20_viewer.views.main_window"),
        *("gpr20_foreign_formats.segy", "gpr20_vna_acquisition.mid.conformance"),
        "gpr20_launch.mid.pin_checks",
    ):
        assert not is_shown[name], name
