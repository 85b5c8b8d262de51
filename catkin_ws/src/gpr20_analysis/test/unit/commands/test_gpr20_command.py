"""The command gpr20: help, exit status, what it says when something is wrong, and hostile texts."""

import json
import os
import random
import shutil
import sys

import pytest
import xarray as xr
from run_seed import draws
from survey_kit import POINTS, make_survey

from gpr20_analysis import errors
from gpr20_analysis.commands import survey_commands
from gpr20_analysis.commands.command import SUMMARIES
from gpr20_analysis.commands.main import main
from gpr20_analysis.sentences import sentences_of
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import verbatim
from gpr20_common.sent_message import received_message
from gpr20_common.terminal_text import is_shown

ALL = len(POINTS)


def test_every_command_explains_itself_and_is_listed_and_a_wrong_call_is_status_3(capsys):
    assert main(["--help"]) == 0
    listed = capsys.readouterr().out
    for name in SUMMARIES:
        assert main([name, "--help"]) == 0
        assert f"gpr20 {name}" in capsys.readouterr().out and name in listed
    for arguments in ([], ["nonsense"], ["info"], ["export", "a", "b"]):
        assert main(arguments) == 3, arguments


def test_an_error_says_which_command_and_what_and_a_remedy_once(finished, tmp_path, capsys):
    (tmp_path / "other.bag").write_text("nothing")
    assert main(["info", str(tmp_path / "other.bag")]) == 3
    assert len(capsys.readouterr().err.splitlines()) == 1
    (tmp_path / "broken.bag").write_text("#ROSBAG V2.0\n")
    assert main(["info", str(tmp_path / "broken.bag")]) == 3
    error = capsys.readouterr().err
    assert error.startswith("gpr20 info: ") and "broken.bag" in error
    assert error.splitlines()[1] == f"First: {errors.NO_INDEX.remedy}"
    assert main(["image", str(finished), "-o", str(tmp_path / "x.txt"), "--json"]) == 3
    printed = capsys.readouterr()
    assert len(printed.err.splitlines()) == 1
    error = json.loads(printed.out)["error"]
    assert error["fault"]["code"] == NOT_ALLOWED.code
    message = received_message("", error["fault"])
    assert message.cause == NOT_ALLOWED and str(message) == error["message"]


@pytest.mark.parametrize(("stored", "status"), [(ALL, 0), (ALL - 3, 1)])
def test_info_tells_how_whole_a_survey_is(tmp_path, capsys, stored, status):
    folder = make_survey(tmp_path, stored, "stopped")
    assert main(["info", str(folder), "--json"]) == status
    printed = json.loads(capsys.readouterr().out)
    assert printed["samples"].startswith(f"{stored} of {ALL} of the grid")
    assert len(printed["missing"]) == ALL - stored


def test_a_library_that_is_not_installed_is_named_with_its_extra(
    finished, tmp_path, capsys, monkeypatch
):
    for name in [one for one in sys.modules if one.startswith("gpr20_analysis.plotting")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["plot", "coverage", str(finished), "-o", str(tmp_path / "c.png")]) == 3
    assert "pip install 'gpr20_analysis[plots]'" in capsys.readouterr().err


def test_a_fault_of_the_program_is_told_in_one_line(finished, capsys, monkeypatch):
    monkeypatch.setattr(survey_commands, "summary_of", lambda survey: 1 / 0)
    assert main(["info", str(finished)]) == 3
    error = capsys.readouterr().err
    assert "ZeroDivisionError" in error
    assert "Traceback" not in error
    monkeypatch.setenv("GPR20_TRACEBACK", "1")
    assert main(["info", str(finished)]) == 3
    assert "Traceback" in capsys.readouterr().err


HOSTILE = (
    *("\x1b]0;owned\x07", "\x1b[2J\x1b[H", "\x9b31m", "\rcomplete and intact", "\x08" * 20),
    *("\nFAULT: faked\n", "a\u202eb", "\u2028line", "\ud800", "\udcff"),
)
COMMANDS = (
    *(["info"], ["info", "--accept-damaged"], ["verify"], ["verify", "--repair"]),
    *(["annotate"], ["info", "--json"], ["verify", "--json"]),
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


@pytest.fixture(autouse=True)
def english(monkeypatch):
    """The language of the environment."""
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("LANG", "en_US.UTF-8")


def test_the_language_is_an_option_anywhere_else_that_of_the_environment(
    stopped, capsys, monkeypatch
):
    for place in range(3):
        arguments = ["verify", str(stopped)]
        arguments[place:place] = ["--language", "es"]
        assert main(arguments) == 1
        assert "INCOMPLETA" in capsys.readouterr().out
    monkeypatch.setenv("LANG", "es_PE.UTF-8")
    assert main(["verify", str(stopped)]) == 1
    assert "INCOMPLETA" in capsys.readouterr().out


def test_why_a_command_did_nothing_and_what_only_analysts_ask_for_is_english(
    tmp_path, stopped, capsys
):
    assert main(["info", str(tmp_path / "nowhere"), "--language", "es"]) == 3
    assert capsys.readouterr().err.endswith("nowhere does not exist\n")
    assert main(["annotate", str(stopped), "--operator", "Ana", "--language", "es"]) == 0
    assert "operator: " in capsys.readouterr().out


def test_verdict_and_warnings_are_translated_but_not_json_for_programs(stopped, capsys):
    assert main(["verify", str(stopped), "--language", "es"]) == 1
    verdict, first = capsys.readouterr().out.splitlines()[-2:]
    assert verdict.startswith("INCOMPLETA") and f"7 de {ALL} " in verdict
    assert first.startswith("Primero: ")
    assert main(["info", str(stopped), "--language", "es"]) == 1
    assert "falta: x " in capsys.readouterr().err
    answers = []
    for language in ("en", "es"):
        assert main(["info", str(stopped), "--json", "--language", language]) == 1
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0] == answers[1]
    assert answers[0]["missing"][0].startswith("missing: x ")


def test_sentences_without_a_template_that_fits_stay_in_english():
    for messages in ("{}", "{", "[]", 5, "[" * 100_000, '{"by hand": "{"}', '{"by hand": 5}'):
        survey = xr.Dataset(attrs={"notes": ["by hand"], "messages": messages})
        assert sentences_of(survey, "notes") == [verbatim("by hand")], messages
