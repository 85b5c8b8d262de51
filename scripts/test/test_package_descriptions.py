"""All packages have one version, maintainer, licence and addresses, and pinned requirements."""

from __future__ import annotations

import re

import metadata
import pytest
from user_shell import ROOT

(VERSION,) = re.findall(
    r'^current_version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE
)
PINNED = {
    "3.8": ["nodes", "test", "system"],
    "3.11": ["nodes", "test", "lint", "docs", "robot"],
    "3.13": ["nodes", "test", "system"],
}


def test_every_package_has_the_metadata_of_the_project():
    for path, text in metadata.written_files(ROOT).items():
        assert path.read_text(encoding="utf-8") == text, "run tools/pages/metadata.py"


@pytest.mark.parametrize(
    ("files", "pattern", "at_least"),
    [
        ("catkin_ws/src/*/package.xml", r"<version>(.+)</version>", 10),
        ("ros2/*/package.xml", r"<version>(.+)</version>", 1),
        ("catkin_ws/src/*/src/*/__init__.py", r'^__version__ = "(.+)"$', 0),
        ("CITATION.cff", r"^version: (.+)$", 1),
    ],
)
def test_every_version_is_that_of_all(files, pattern, at_least):
    found = [
        version
        for path in ROOT.glob(files)
        for version in re.findall(pattern, path.read_text(), re.MULTILINE)
    ]
    assert len(found) >= at_least
    assert set(found) <= {VERSION}, "change it by scripts/release.sh and nowhere by hand"


def test_the_changelog_that_release_tools_of_ros_read_has_the_version():
    changelog = pytest.importorskip("catkin_pkg.changelog")
    released = changelog.get_changelog_from_path(str(ROOT / "catkin_ws/src/gpr20"))
    version, _date, entries = next(iter(released.foreach_version(reverse=True)))
    assert version == VERSION, "the heading is that of the last release: `VERSION (DATE)`"
    assert entries


def names(path):
    """Return the packages of a requirements file, as pip compares them."""
    found = re.findall(r"^([A-Za-z][\w.-]*)(?!.*python_version)", path.read_text(), re.MULTILINE)
    return {re.sub(r"[-_.]+", "-", one).lower() for one in found}


@pytest.mark.parametrize("python", PINNED)
def test_every_listed_requirement_is_pinned(python):
    pinned = names(ROOT / f"requirements/python{python}.txt")
    for listed in PINNED[python]:
        missing = names(ROOT / f"requirements/{listed}.in") - pinned
        assert not missing, f"run scripts/requirements.sh: no version of {sorted(missing)}"
