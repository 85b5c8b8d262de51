"""All packages have one version number, the one that pyproject.toml names."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CHANGE = "change it by scripts/release.sh and nowhere by hand"
(VERSION,) = re.findall(
    r'^current_version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE
)
WRITTEN = {
    str(path.relative_to(ROOT)): re.findall(pattern, path.read_text(), re.MULTILINE)
    for files, pattern in (
        ("catkin_ws/src/*/package.xml", r"<version>(.+)</version>"),
        ("ros2/*/package.xml", r"<version>(.+)</version>"),
        ("catkin_ws/src/*/src/*/__init__.py", r'^__version__ = "(.+)"$'),
        ("CITATION.cff", r"^version: (.+)$"),
    )
    for path in sorted(ROOT.glob(files))
}


@pytest.mark.parametrize("file", [file for file, versions in WRITTEN.items() if versions])
def test_the_version_is_that_of_all(file):
    assert WRITTEN[file] == [VERSION], CHANGE


def test_every_package_has_a_version():
    packages = [file for file in WRITTEN if file.endswith("package.xml")]
    assert len(packages) > 10
    assert all(WRITTEN[file] for file in packages)


def test_the_changelog_that_release_tools_of_ros_read_has_the_version():
    changelog = pytest.importorskip("catkin_pkg.changelog")
    released = changelog.get_changelog_from_path(str(ROOT / "catkin_ws/src/gpr20"))
    version, _date, entries = next(iter(released.foreach_version(reverse=True)))
    assert version == VERSION, "the heading is that of the last release: `VERSION (DATE)`"
    assert entries
