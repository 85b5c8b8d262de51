"""The command gpr20: help, exit status, and what it says when something is wrong."""

from __future__ import annotations

import json
import sys

import pytest
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands import info_command
from gpr20_analysis.commands.command import SUMMARIES
from gpr20_analysis.commands.main import main
from gpr20_analysis.verify import main as gpr20_verify
from gpr20_common.sent_message import received_message

ALL = len(POINTS)


@pytest.mark.parametrize("name", SUMMARIES)
def test_every_command_explains_itself(name, capsys):
    assert main([name, "--help"]) == 0
    assert f"gpr20 {name}" in capsys.readouterr().out


def test_help_lists_every_command(capsys):
    assert main(["--help"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in SUMMARIES)


@pytest.mark.parametrize("arguments", [[], ["nonsense"], ["info"], ["export", "a", "b"]])
def test_a_wrong_call_is_status_3(arguments):
    assert main(arguments) == 3


def test_an_error_says_which_command_and_what(tmp_path, capsys):
    assert main(["info", str(tmp_path / "nowhere")]) == 3
    error = capsys.readouterr().err
    assert error.startswith("gpr20 info: ") and "nowhere" in error
    assert error.splitlines()[1] == f"First: {faults.NO_INPUT.remedy}"


def test_a_step_that_the_message_says_is_not_said_twice(tmp_path, capsys):
    folder = make_survey(tmp_path, ALL, "finished")
    assert main(["report", str(folder), "-o", str(tmp_path / "x.txt"), "--json"]) == 3
    printed = capsys.readouterr()
    assert len(printed.err.splitlines()) == 1
    error = json.loads(printed.out)["error"]
    assert error["fault_code"] == faults.OUTPUT.code
    message = received_message("", error["message_json"])
    assert message.cause == faults.OUTPUT and str(message) == error["message"]


@pytest.mark.parametrize(("stored", "status"), [(ALL, 0), (ALL - 3, 1)])
def test_info_tells_how_whole_a_survey_is(tmp_path, capsys, stored, status):
    folder = make_survey(tmp_path, stored, "stopped")
    assert main(["info", str(folder), "--json"]) == status
    printed = json.loads(capsys.readouterr().out)
    assert printed["samples"].startswith(f"{stored} of {ALL} of the grid")
    assert len(printed["missing"]) == ALL - stored
    assert printed["frequency"] == "5 from 0.6 to 6 GHz, every 1350 MHz"


def test_info_of_a_damaged_survey_is_refused_or_marked(tmp_path, capsys):
    folder = make_survey(tmp_path, ALL, "finished")
    next((folder / "traces").glob("000002_*")).write_text("{")
    assert main(["info", str(folder)]) == 3
    assert "000002_" in capsys.readouterr().err
    assert main(["info", str(folder), "--accept-damaged"]) == 2
    assert "DAMAGED: 000002_" in capsys.readouterr().err


def test_gpr20_verify_and_its_former_name_say_the_same(tmp_path, capsys):
    folder = make_survey(tmp_path, ALL, "finished")
    assert main(["verify", str(folder)]) == gpr20_verify([str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert lines[:2] == lines[2:]


def test_replay_without_a_survey_is_refused(tmp_path, capsys):
    assert main(["replay", str(tmp_path / "nowhere")]) == 3
    assert "nowhere" in capsys.readouterr().err


def test_a_library_that_is_not_installed_is_named_with_its_extra(tmp_path, capsys, monkeypatch):
    folder = make_survey(tmp_path, ALL, "finished")
    for name in [one for one in sys.modules if one.startswith("gpr20_analysis.plotting")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["plot", "coverage", str(folder), "-o", str(tmp_path / "c.png")]) == 3
    assert "pip install 'gpr20_analysis[plots]'" in capsys.readouterr().err


def test_a_fault_of_the_program_is_told_in_one_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(info_command, "summary_of", lambda survey: 1 / 0)
    folder = make_survey(tmp_path, ALL, "finished")
    assert main(["info", str(folder)]) == 3
    error = capsys.readouterr().err
    assert "ZeroDivisionError" in error
    assert "Traceback" not in error
    monkeypatch.setenv("GPR20_TRACEBACK", "1")
    assert main(["info", str(folder)]) == 3
    assert "Traceback" in capsys.readouterr().err
