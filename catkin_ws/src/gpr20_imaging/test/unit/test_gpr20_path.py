from __future__ import annotations

import sys

import pytest

from gpr20_imaging.low import analysis_command


@pytest.mark.parametrize("library, found", [("json", True), ("no_such_library", False)])
def test_a_command_whose_libraries_are_missing_is_not_installed(
    tmp_path, monkeypatch, library, found
):
    # Every sourced workspace has the command, also where only the robot's packages are installed.
    (tmp_path / "gpr20").touch(mode=0o755)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python3"))
    monkeypatch.setattr(analysis_command, "LIBRARY", library)
    assert (analysis_command.gpr20_path() is not None) == found
