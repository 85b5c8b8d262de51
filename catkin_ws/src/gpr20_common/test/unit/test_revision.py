"""Which software this is, and where its data are."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from case_kit import each_case

from gpr20_common.low.yaml_file import data_folder
from gpr20_common.mid import node_facts


@pytest.fixture
def installed(tmp_path, monkeypatch):
    monkeypatch.setattr("gpr20_common.__version__", "1.2.3")
    monkeypatch.setattr(node_facts, "INSTALLED_REVISION", tmp_path / "installed_revision")
    return tmp_path / "installed_revision"


def test_sources_without_git_are_named_by_their_version(installed):
    assert (node_facts.git_revision(), node_facts.software_revision()) == ("", "1.2.3")


@each_case("recorded, said", [("abc1234\n", "1.2.3 (git abc1234)"), ("", "1.2.3")])
def test_an_installed_package_has_the_revision_of_its_sources(installed, recorded, said):
    # Here it is installed inside the checkout of something else.
    subprocess.run(["git", "-C", str(installed.parent), "init", "-q"], check=True)
    installed.write_text(recorded)
    assert node_facts.software_revision() == said


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
