"""The table of traps names tests that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
TABLE = ROOT / "docs" / "traps.md"
NAMED = sorted(set(re.findall(r"`(\w+\.py)::(\w+)`", TABLE.read_text(encoding="utf-8"))))
ROWS = {f"{number}" for number in range(1, 40)} | {"15b", "15c", "25b"}


@pytest.mark.parametrize("file_name, test", NAMED)
def test_a_test_that_the_table_names_exists(file_name, test):
    folders = [*ROOT.glob("catkin_ws/src/*/test"), ROOT / "launch" / "test"]
    files = {path.resolve() for folder in folders for path in folder.rglob(file_name)}
    assert len(files) == 1, f"{file_name} is not one file"
    assert re.search(rf"^ *def {test}\(", files.pop().read_text(encoding="utf-8"), re.MULTILINE)


def test_every_trap_has_a_row_with_a_test():
    rows = dict(re.findall(r"^\| (\w+) \|.*\| (.*) \|$", TABLE.read_text(encoding="utf-8"), re.M))
    assert set(rows) == ROWS
    assert all(".py" in guard for guard in rows.values())
