"""The list of known faults names tests that exist."""

from __future__ import annotations

import re
from pathlib import Path

from case_kit import each_case
from wings_kit import NEEDS_ALL

ROOT = Path(__file__).resolve().parents[5]
LIST = (ROOT / "docs/evidence/traps.md").read_text(encoding="utf-8")
FAULTS = {f"{number}" for number in range(1, 46)} | {"6b", "6c", "6d", "15b", "15c", "25b"}


def named_tests(text):
    """Return (file name, test) for each test below its file in a list."""
    named, file_name = set(), None
    for line in text.splitlines():
        file_line = re.fullmatch(r"- `(\w+\.py)`", line)
        test_line = re.fullmatch(r"  - `(\w+)`", line)
        if file_line:
            file_name = file_line[1]
        elif test_line:
            named.add((file_name, test_line[1]))
    return named


@each_case("file_name, test", sorted(named_tests(LIST)))
@NEEDS_ALL
def test_a_test_that_the_list_names_exists(file_name, test):
    folders = ROOT.glob("catkin_ws/src/*/test")
    files = {path.resolve() for folder in folders for path in folder.rglob(file_name)}
    assert len(files) == 1, f"{file_name} is not one file"
    assert re.search(rf"^ *def {test}\(", files.pop().read_text(encoding="utf-8"), re.MULTILINE)


def test_every_fault_has_a_section_with_a_test():
    sections = dict(re.findall(r"^### (\w+)\. .*\n((?:(?!#).*\n)*)", LIST, re.MULTILINE))
    assert set(sections) == FAULTS
    assert [number for number, text in sections.items() if not named_tests(text)] == []
