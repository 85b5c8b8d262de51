"""The command gpr20: help, exit status, what it says when something is wrong, and hostile texts."""

from __future__ import annotations

import json
import os
import random
import shutil
import sys

import pytest
from run_seed import draws
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands import info_command
from gpr20_analysis.commands.command import SUMMARIES
from gpr20_analysis.commands.main import main
from gpr20_common.sent_message import received_message
from gpr20_common.terminal_text import is_shown

ALL = len(POINTS)


def test_every_command_explains_itself_and_is_listed(capsys):
    assert main(["--help"]) == 0
    listed = capsys.readouterr().out
    for name in SUMMARIES:
        assert main([name, "--help"]) == 0
        assert f"gpr20 {name}" in capsys.readouterr().out and name in listed


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


HOSTILE = (
    *("\x1b]0;owned\x07", "\x1b[2J\x1b[H", "\x9b31m", "\rcomplete and intact", "\x08" * 20),
    *("\nFAULT: faked\n", "a\u202eb", "\u2028line", "\ud800", "\udcff"),
)
COMMANDS = (
    *(["info"], ["info", "--accept-damaged"], ["verify", "--all"], ["repair"], ["markers"]),
    *(["annotate"], ["info", "--json"], ["verify", "--json"], ["markers", "--json"]),
)
MORE = {
    "instrument": {"identity": "ANRITSU,MS2026C,1,1", "calibration": "applied"},
    "nodes": [{"name": "vna", "simulated": False, "hardware": "MS2026C", "host": "pi"}],
    "robot": {"name": "robot1", "site": "Bogota", "operator": "Ana"},
    "annotation": {"name": "x", "operator": "y", "site": "z", "notes": "n", "position": None,
                   "heading_deg": None},
}  # fmt: skip


def texts_of(values, place=()):
    """Yield where the texts of a JSON object are."""
    items = values.items() if isinstance(values, dict) else enumerate(values)
    for key, value in items:
        if isinstance(value, (dict, list)):
            yield from texts_of(value, (*place, key))
        elif isinstance(value, str):
            yield (*place, key)


def put_text(folder, draw):
    path = draw.choice([folder / "survey.json", *sorted((folder / "traces").iterdir())[:3]])
    values = json.loads(path.read_text())
    *above, last = draw.choice([one for one in texts_of(values) if one[-1] != "format"])
    inner = values
    for key in above:
        inner = inner[key]
    inner[last] = draw.choice(HOSTILE) + draw.choice(["", inner[last]])
    path.write_text(json.dumps(values, indent=2) + "\n")


def put_name(folder, draw):
    name = os.fsencode("x" + draw.choice(HOSTILE[:8])) + draw.choice([b"", b"\xff.json"])
    place = os.fsencode(draw.choice([folder, folder / "traces"]))
    with open(os.path.join(place, name), "wb") as stream:
        stream.write(b"{}")


def test_whatever_a_survey_says_is_shown_on_the_lines_of_the_command(tmp_path, capsys):
    stored = make_survey(tmp_path / "stored", len(POINTS), "finished", more=MORE)
    draw = random.Random(27)
    broken = []
    for number in range(draws(10)):
        folder = tmp_path / str(number) / stored.name
        shutil.copytree(str(stored), str(folder))
        if draw.random() < 0.6:
            (folder / "manifest.json").unlink()
        put = draw.choice([put_text, put_name])
        put(folder, draw)
        command = draw.choice(COMMANDS)
        main([*command, str(folder)])
        printed = capsys.readouterr()
        shown = (printed.out + printed.err).split("\n")
        case = f"{number}: {' '.join(command)} after {put.__name__}"
        if any(not is_shown(one) for line in shown for one in line):
            broken.append(f"{case}: {shown!r}")
        if any(line.startswith("FAULT: faked") for line in shown):
            broken.append(f"{case}: a line is faked")
        if "program error" in printed.err:
            broken.append(f"{case}: {printed.err}")
    assert not broken, "\n".join(broken)
