"""What a file or a device says on a terminal is shown, and controls nothing."""

from __future__ import annotations

import io
import os
from pathlib import Path

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.terminal_text import enable_line_buffering, is_shown, printable, say

ANYTHING = st.text(
    st.one_of(
        st.characters(),
        st.characters(whitelist_categories=("Cs", "Cc", "Zl", "Zp")),
        st.sampled_from("\u202e\u2066\x9b\x1b\n\t\udcff"),
    )
)


@given(ANYTHING)
def test_every_text_becomes_one_line_that_is_shown(text):
    shown = printable(text)
    assert all(map(is_shown, shown)) and len(shown.splitlines()) <= 1
    assert shown.encode("utf-8").decode("utf-8") == shown == printable(shown)


@each_case(
    "text, expected",
    [
        ("\x1b]0;title\x07 \x1b[2J", r"\x1b]0;title\x07 \x1b[2J"),
        ("intact\rDAMAGED\n", r"intact\rDAMAGED\n"),
        ("a\u202eb\u2028c", r"a\u202eb\u2028c"),
        (os.fsdecode(b"caf\xe9"), r"caf\xe9"),
        (Path("/ñ/地雷/می‌خواهم"), "/ñ/地雷/می‌خواهم"),
    ],
)
def test_what_controls_a_terminal_is_spelled_out(text, expected):
    assert printable(text) == expected


@given(st.lists(ANYTHING, min_size=1))
def test_as_many_lines_are_printed_as_are_said(lines):
    stream = io.StringIO()
    say(*lines, file=stream)
    assert stream.getvalue().split("\n")[:-1] == [printable(one) for one in lines]


@pytest.fixture
def file(tmp_path):
    with (tmp_path / "log").open("w") as opened:
        yield opened


def test_a_line_in_a_file_is_seen_when_it_is_said(file, tmp_path, monkeypatch):
    monkeypatch.setattr("sys.stdout", file)
    enable_line_buffering()
    file.write("the robot is ready\n")
    assert (tmp_path / "log").read_text() == "the robot is ready\n"
