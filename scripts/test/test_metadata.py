"""All packages have the maintainer, the licence and the addresses that CITATION.cff names."""

from __future__ import annotations

import re

import metadata
import pytest
from user_shell import ROOT

CITATION = {
    "contact": [{"name": "R&D", "email": "people@robot.example"}],
    "license": "GPL-3.0-or-later",
    "url": "https://robot.example",
    "repository-code": "https://code.example/robot",
}
ADDRESSES = {
    "website": "https://robot.example",
    "repository": "https://code.example/robot",
    "bugtracker": "https://code.example/robot/issues",
}
WRITTEN = {path.relative_to(ROOT): text for path, text in metadata.written_files(ROOT).items()}


def without_addresses():
    """Return a description of the software that names no address yet."""
    return {name: CITATION[name] for name in ("contact", "license")}


@pytest.mark.parametrize("path", WRITTEN, ids=str)
def test_a_package_has_the_metadata_of_the_project(path):
    text = (ROOT / path).read_text(encoding="utf-8")
    assert text == WRITTEN[path], "run .venv/bin/python tools/pages/metadata.py"


def test_addresses_reach_each_package_and_leave_it_again():
    read_package = pytest.importorskip("catkin_pkg.package").parse_package_string
    path = ROOT / "catkin_ws/src/gpr20/package.xml"
    text = metadata.package_xml(path.read_text(encoding="utf-8"), CITATION)
    package = read_package(text)
    assert {url.type: url.url for url in package.urls} == ADDRESSES
    (maintainer,) = package.maintainers
    assert (maintainer.name, maintainer.email) == ("R&D", "people@robot.example")
    assert metadata.package_xml(text, CITATION) == text
    assert "<url" not in metadata.package_xml(text, without_addresses())


@pytest.mark.parametrize("package", ["gpr20_analysis", "gpr20_viewer"])
def test_addresses_reach_each_wheel_and_leave_it_again(package):
    old = (ROOT / f"catkin_ws/src/{package}/pyproject.toml").read_text(encoding="utf-8")
    text = metadata.pyproject(old, CITATION)
    (table,) = re.findall(r"^\[project\.urls\]\n((?:.+\n)*)\n", text, re.MULTILINE)
    assert dict(re.findall(r'(\w+) = "(.+)"', table)) == ADDRESSES
    assert metadata.pyproject(text, CITATION) == text
    assert metadata.pyproject(text, without_addresses()).count("[project.urls]") == 0
