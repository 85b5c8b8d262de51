import io

import pytest

from gpr20_common.low.line_output import enable_line_buffering


@pytest.fixture
def file(tmp_path):
    with (tmp_path / "log").open("w") as opened:
        yield opened


def test_a_line_in_a_file_is_seen_when_it_is_said(file, tmp_path):
    enable_line_buffering(file)
    file.write("the robot is ready\n")
    assert (tmp_path / "log").read_text() == "the robot is ready\n"


def test_standard_output_is_meant_if_nothing_else_is(file, tmp_path, monkeypatch):
    monkeypatch.setattr("sys.stdout", file)
    enable_line_buffering()
    file.write("PAUSED\n")
    assert (tmp_path / "log").read_text() == "PAUSED\n"


def test_what_is_no_buffered_file_is_left_as_it_is(monkeypatch):
    enable_line_buffering(io.StringIO())
    monkeypatch.setattr("sys.stdout", None)
    enable_line_buffering()
