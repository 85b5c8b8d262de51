"""Which Python the nodes of an install space run in after it was sourced."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from case_kit import each_case

HOOK = Path(__file__).resolve().parents[2] / "env-hooks" / "60.gpr20_venv.sh"
SYSTEM = "/usr/bin:/bin"


@pytest.fixture
def path_after(tmp_path):
    """Source install spaces in turn in one shell; return PATH, relative to their folder."""

    def source(*names, before=SYSTEM):
        lines = [f'CATKIN_ENV_HOOK_WORKSPACE="{tmp_path / name}"; . "{HOOK}"' for name in names]
        ended = subprocess.run(
            ["/bin/sh", "-euc", "\n".join([*lines, 'echo "$PATH"'])],
            env={"PATH": before},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
        return ended.stdout.strip().replace(f"{tmp_path}/", "").split(":")

    for name in ("one", "other"):
        program = tmp_path / name / "venv/bin/python3"
        program.parent.mkdir(parents=True)
        program.touch(mode=0o755)
    (tmp_path / "without").mkdir()
    return source


def test_the_python_of_an_install_space_comes_first(path_after):
    assert path_after("one") == ["one/venv/bin", "/usr/bin", "/bin"]
    assert path_after("one", before="/home/user/.venv/bin:/bin")[0] == "one/venv/bin"


def test_a_workspace_without_an_environment_changes_nothing(path_after):
    assert path_after("without") == ["/usr/bin", "/bin"]


@each_case("names", [("one", "other"), ("one", "other", "other")])
def test_the_one_that_was_sourced_last_counts(path_after, names):
    assert path_after(*names) == ["other/venv/bin", "/usr/bin", "/bin"]
    assert path_after(*names, "one") == ["one/venv/bin", "/usr/bin", "/bin"]
    assert path_after(*names, "without") == ["/usr/bin", "/bin"]
