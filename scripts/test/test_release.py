"""scripts/release.sh changes every version and the changelog, commits and tags."""

from __future__ import annotations

import sys

import pytest
from user_shell import ROOT, printed_by

pytestmark = pytest.mark.release
CHANGELOG = "catkin_ws/src/gpr20/CHANGELOG.rst"
PERSON = {
    f"GIT_{role}_{name}": f"releaser{ending}"
    for role in ("AUTHOR", "COMMITTER")
    for name, ending in (("NAME", ""), ("EMAIL", "@robot.example"))
}


@pytest.fixture
def clone(tmp_path):
    """A clone on main whose changelog has one new entry."""
    folder = tmp_path / "clone"
    run(tmp_path, "git", "clone", "--quiet", "--depth=1", f"file://{ROOT}", str(folder))
    run(folder, "git", "checkout", "--quiet", "-B", "main")
    (folder / ".venv").symlink_to(sys.prefix)
    (folder / ".git/info/exclude").write_text(".venv\n")
    changelog = folder / CHANGELOG
    title, releases = changelog.read_text(encoding="utf-8").split("notice.\n\n", 1)
    released = releases[releases.index("0.1.0 (") :]
    new = "Forthcoming\n-----------\n\n- Something new.\n\n"
    changelog.write_text(f"{title}notice.\n\n{new}{released}", encoding="utf-8")
    run(folder, "git", "commit", "--quiet", "--all", "--allow-empty", "--message", "A change")
    return folder


def run(folder, *command):
    return printed_by(*command, folder=folder, **PERSON)


def test_a_release_is_a_commit_and_an_annotated_tag_of_a_plain_number(clone):
    changelog = pytest.importorskip("catkin_pkg.changelog")
    before = run(clone, "git", "status", "--porcelain", "--branch")
    printed = run(clone, "scripts/release.sh", "--dry-run", "99.0.0")
    assert f"would change {CHANGELOG}" in printed
    assert run(clone, "git", "status", "--porcelain", "--branch") == before
    printed = run(clone, "scripts/release.sh", "--no-tests", "99.0.0")
    assert "git push origin main 99.0.0" in printed
    assert run(clone, "git", "status", "--porcelain") == ""
    assert run(clone, "git", "cat-file", "-t", "99.0.0") == "tag\n"
    released = changelog.get_changelog_from_path(str(clone / "catkin_ws/src/gpr20"))
    version, date, entries = next(iter(released.foreach_version(reverse=True)))
    assert (version, [str(entry) for entry in entries]) == ("99.0.0", ["* Something new."])
    assert f"date-released: {date:%Y-%m-%d}\n" in (clone / "CITATION.cff").read_text()
