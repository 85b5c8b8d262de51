"""The rules of the sources: the lint, the size of each part, imports, sentences."""

from __future__ import annotations

import re

import pytest
from house import limits, lines_by_part
from user_shell import ROOT, printed_by

SOURCES = sorted(
    [*ROOT.glob("catkin_ws/src/*/src/*/__init__.py"), *ROOT.glob("deploy/*/*/__init__.py")],
    key=lambda one: one.parent.name,
)


@pytest.mark.timeout(450)
def test_the_lint_finds_nothing():
    printed_by(ROOT / "scripts/lint.sh")


def test_no_part_is_larger_than_its_limit_in_pyproject():
    found, allowed = lines_by_part(), limits()
    assert found.keys() == allowed.keys()
    assert {one: number for one, number in found.items() if number > allowed[one]} == {}


def test_every_package_is_covered_by_the_contracts_on_imports():
    contracts = (ROOT / "pyproject.toml").read_text()
    roots = contracts.split("root_packages = [")[1].split("]")[0]
    assert re.findall(r'"(\w+)"', roots) == [one.parent.name for one in SOURCES]
