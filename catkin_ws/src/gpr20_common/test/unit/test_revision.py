"""Which software this is, and where its data are."""

from __future__ import annotations

import subprocess
from pathlib import Path

from case_kit import each_case

from gpr20_common.low.data_folder import data_folder
from gpr20_common.mid.node_facts import git_revision, software_revision


def test_sources_without_git_are_named_by_their_version(tmp_path):
    assert git_revision(tmp_path) == ""
    assert software_revision("1.2.3", tmp_path) == "1.2.3"
    assert software_revision("1.2.3", tmp_path / "missing") == "1.2.3"


@each_case("recorded, said", [("abc1234\n", "1.2.3 (git abc1234)"), ("", "1.2.3")])
def test_an_installed_package_has_the_revision_of_its_sources(tmp_path, recorded, said):
    # Here it is installed inside the checkout of something else.
    subprocess.run(["git", "-C", str(tmp_path), "init", "-q"], check=True)
    installed = tmp_path / "installed_revision"
    installed.write_text(recorded)
    assert software_revision("1.2.3", tmp_path, installed) == said


@each_case(
    "configured, environment, folder",
    [
        ("/disk/a", {"GPR20_DATA": "/disk/b"}, Path("/disk/a")),
        (" ", {"GPR20_DATA": "~/b"}, Path.home() / "b"),
        ("", {"GPR20_DATA": ""}, Path.home() / "gpr20_data"),
        ("a", {}, Path.cwd() / "a"),
    ],
)
def test_the_folder_of_the_data_is_the_parameter_or_of_the_environment_or_the_home(
    configured, environment, folder
):
    assert data_folder(configured, environment) == folder
