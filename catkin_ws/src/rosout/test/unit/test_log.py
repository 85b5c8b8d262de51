"""The log's lines and its file."""

from __future__ import annotations

import pytest

from rosout.low.log_file import LogFile
from rosout.mid.log_entry import LogEntry


@pytest.mark.parametrize(
    ("level", "name"), [(1, "DEBUG"), (2, "INFO"), (4, "WARN"), (8, "ERROR"), (16, "FATAL")]
)
def test_an_entry_tells_when_how_grave_who_where_and_what(level, name):
    entry = LogEntry(12.5, level, "/x_axis/axis_driver", "axis.py:7(home)", "no endstop\n")
    assert entry.line() == f"12.500000 {name} /x_axis/axis_driver [axis.py:7(home)] no endstop"


def test_a_text_of_several_lines_cannot_be_taken_for_several_entries():
    line = LogEntry(1.0, 2, "/a", "f:1(g)", "first\n9.0 FATAL /b [f:1(g)] forged").line()
    assert line.splitlines() == [
        "1.000000 INFO /a [f:1(g)] first",
        "    9.0 FATAL /b [f:1(g)] forged",
    ]


def test_an_unknown_level_is_told_by_its_number():
    assert " level 3 " in LogEntry(1.0, 3, "/a", "f:1(g)", "x").line()


def test_the_file_and_its_folder_are_made_and_kept_when_opened_again(tmp_path):
    path = tmp_path / "log" / "rosout.log"
    for text in ("one", "two %s"):
        file = LogFile(path)
        file.write(text)
        file.close()
    assert path.read_text() == "one\ntwo %s\n"


def test_a_large_file_is_put_aside_and_the_oldest_deleted(tmp_path):
    file = LogFile(tmp_path / "rosout.log", largest_bytes=20, kept_files=2)
    for number in range(10):
        file.write(f"entry number {number}")
    file.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "rosout.log",
        "rosout.log.1",
        "rosout.log.2",
    ]
    assert (tmp_path / "rosout.log").read_text() == "entry number 9\n"
