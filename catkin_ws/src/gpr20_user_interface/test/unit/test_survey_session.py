"""The terminal client: its command line, its lines and last words, times, and a question."""

import io
import os
import pty
import queue
import re
from types import SimpleNamespace

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from view_kit import ASKED_PAUSE, FULL, LOST, state_of

from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_operator.robot.events import (
    DOCUMENTED_TRAVEL,
    Answer,
    ControlState,
    Progress,
    Request,
)
from gpr20_operator.words import duration
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_parameters import find_problems
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_user_interface.terminal.displays import BarDisplay, PlainDisplay, is_confirmed, remaining
from gpr20_user_interface.terminal.follower import (
    ExitStatus,
    Limits,
    Mode,
    OnPause,
    Outcome,
    SurveyFollower,
)
from gpr20_user_interface.terminal.session import (
    SIMULATED,
    SurveySession,
    first_step,
    outcome_lines,
)
from gpr20_user_interface.terminal.survey_arguments import Bar, terminal_language
from gpr20_user_interface.terminal.survey_arguments import parse_arguments as parse


def parse_arguments(arguments):
    return parse(arguments, Catalogue())


def test_defaults_are_a_survey_that_can_be_run():
    options = parse_arguments([])
    assert find_problems(options.parameters, DOCUMENTED_TRAVEL) == []
    assert options.parameters.vna_address == ""
    assert options.parameters.sweep_settings.analyzer == AnalyzerSettings()
    assert options.permittivity == 0.0 and options.annotation == EMPTY
    assert (options.mode, options.on_pause, options.bar) == (Mode.START, OnPause.EXIT, Bar.AUTO)


def test_a_survey_that_exists_can_be_followed():
    for line, mode, resume_id, analyzer in (
        ("--attach", Mode.ATTACH, "", ""),
        ("--resume --accept-analyzer A,B/2", Mode.RESUME, "", "A,B/2"),
        ("--resume 1234", Mode.RESUME, "1234", ""),
        ("--resume /data/20260921T141320_0f8fad5b/", Mode.RESUME, "20260921T141320_0f8fad5b", ""),
    ):
        options = parse_arguments(line.split())
        found = options.mode, options.resume_id, options.accept_analyzer
        assert found == (mode, resume_id, analyzer)


def test_wrong_command_line_has_status_2_and_names_the_fault(capsys):
    for arguments, words in (
        (["--x-points", "three"], "three"),
        (["--polarizations-deg", "0,x"], "0,x"),
        (["--wait", "0"], "'0'"),
        (["--attach", "--resume"], "not allowed with"),
        (
            ["--attach", "--y-stop", "9", "--polar", "0"],
            "--y-stop-mm, --polarizations-deg cannot be given with",
        ),
        (["--position", "91,0"], "latitude is 91 deg; it must lie between -90 and 90 deg"),
        (["--operator", "a\nb"], "operator holds U+000A"),
        (["--resume", "--site", ""], "--site cannot be given with --resume"),
        (["--permittivity", "0.5"], "'0.5' is no permittivity of a soil"),
        (["--resume", "--permittivity", "4"], "--permittivity cannot be given with --resume"),
        (["--attach", "--accept-analyzer", "B"], "only with --resume"),
    ):
        with pytest.raises(SystemExit) as caught:
            parse_arguments(arguments)
        assert caught.value.code == 2
        assert words in capsys.readouterr().err, arguments


FIELDS = (
    *("vna-address", "start-frequency-mhz", "stop-frequency-mhz", "frequency-points"),
    *("x-start-mm", "x-stop-mm", "x-points", "y-start-mm", "y-stop-mm", "y-points"),
    *("polarizations-deg", "if-bandwidth-hz", "averages", "output-power", "permittivity"),
    *("name", "operator", "site", "notes", "position"),
)


def test_help_lists_fields_and_exit_statuses_in_the_language_of_the_catalogue_as_faults_are(
    capsys,
):
    spanish = read_catalogue(Language.SPANISH)
    with pytest.raises(SystemExit) as caught:
        parse(["--help"], spanish)
    assert caught.value.code == 0
    text = capsys.readouterr().out
    assert all(f"\n  {status:>3}  " in text for status in (2, *map(int, ExitStatus)))
    assert all(f"\n  --{name} " in text for name in FIELDS)
    assert "(por defecto 15)" in " ".join(text.split())
    # But for the example of a position, which is typed so.
    assert not re.search(r"\d\.\d{1,2}(?!\d)", text)
    assert text.startswith("uso: ") and "show this help" not in text


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--wait", "0"], "'0' no es un número de segundos mayor que cero"),
        (["--wait"], "argumento --wait: se espera un valor"),
        (["--bar", "no"], "valor no permitido: 'no' (elija entre "),
        (["--permittivity", "0,5"], "'0,5' no es una permitividad"),
        (["--none"], "argumentos desconocidos: --none"),
        (["--attach", "--resume"], "no se permite junto con el argumento --attach"),
        (["--a"], "opción ambigua: --a puede ser "),
        (["--attach=5"], "no admite el valor '5'"),
    ],
)
def test_what_is_wrong_with_the_command_line_is_said_in_its_language(capsys, arguments, words):
    with pytest.raises(SystemExit) as caught:
        parse(arguments, read_catalogue(Language.SPANISH))
    assert caught.value.code == 2
    said = capsys.readouterr().err
    assert words in said and "run_survey: error: " in said and said.startswith("uso: ")
    assert not re.search("usage|argument |expected|invalid|choose", said)


def test_language_is_that_of_the_command_line_or_the_terminal():
    peru = {"LANG": "es_PE.UTF-8"}
    for line, environment, language in (
        ("", peru, Language.SPANISH),
        ("--language en", peru, Language.ENGLISH),
        ("--attach --language=es --wait 3", {}, Language.SPANISH),
        # Refused by the parser that comes next.
        ("--language fr", peru, Language.SPANISH),
        ("--language", {}, Language.ENGLISH),
    ):
        assert terminal_language(line.split(), environment) == language, line


class Recorder:
    """A display that remembers."""

    def __init__(self):
        self.shown, self.closed = [], False

    def note(self, message):
        self.shown.append(str(message))

    def show(self, progress, state):
        self.shown.append((state.code.name, progress.visited_points))

    def close(self):
        self.closed = True


def state(code, survey_id="ours"):
    return ControlState(SurveyState[code], verbatim("as it is"), survey_id, True)


BEGIN = (
    state("IDLE", ""),
    Answer(Request.START, True, verbatim(""), "ours"),
    state("SURVEYING"),
)


def run(clock, *events):
    """Follow a survey; where there is no event, time passes."""
    left, recorder = iter(events), Recorder()

    def get(timeout):
        event = next(left, None)
        if event is None:
            clock.advance(timeout)
            raise queue.Empty
        return event

    follower = SurveyFollower(Mode.START, OnPause.EXIT, Limits(), clock)
    session = SurveySession(follower, SimpleNamespace(get=get), [].append, recorder)
    return session.run(), recorder


def test_a_state_is_told_once_per_change_and_the_last_trace_though_it_comes_after_the_end(clock):
    outcome, recorder = run(
        clock,
        *BEGIN,
        state("SURVEYING"),
        Progress("ours", 50.0, 18, 9, 30.0),
        state("CHECKING"),
        state("CHECKING"),
        state("FINISHED"),
        None,
        Progress("former", 100.0, 8, 8, 0.0),
        Progress("ours", 100.0, 18, 18, 0.0),
        Progress("ours", 100.0, 18, 18, 0.0),
    )
    assert outcome.status is ExitStatus.FINISHED
    assert recorder.closed
    assert recorder.shown[1:] == [
        "SURVEYING: as it is",
        ("SURVEYING", 9),
        "CHECKING: as it is",
        ("CHECKING", 9),
        ("CHECKING", 18),
    ]


def test_a_warning_during_the_survey_has_its_remedy_and_what_may_move_once(clock):
    warped = Fault("mast.warped", verbatim("Straighten."), Severity.WARNING, may_move=True)

    def warns(number, fault=warped):
        message = Message("warped by {number} mm", number=number).with_fault(fault)
        return ControlState(SurveyState.SURVEYING, message, "ours", False)

    note = Fault("survey.later", verbatim("Nothing."), Severity.NOTE)
    _outcome, recorder = run(clock, *BEGIN, warns(1), warns(2), warns(3, note), state("FINISHED"))
    steps = [one for one in recorder.shown if "Do this first" in str(one)]
    hands_off = "Keep your hands clear: the robot may still move. Straighten."
    assert steps == [f"Do this first: {hands_off} (mast.warped)"]


def test_plain_lines_neither_control_the_terminal_nor_add_lines():
    stream = io.StringIO()
    PlainDisplay(stream, Catalogue()).note(verbatim("a\x1b[2J\nSurvey finished."))
    assert stream.getvalue() == "a\\x1b[2J\\nSurvey finished.\n"


def lines_of(status, message, simulated=False, stored=False):
    messages = outcome_lines(Outcome(status, message), "an-id", simulated, stored)
    return [str(line) for line in messages]


def test_last_words_tell_how_a_survey_that_ended_early_is_resumed_if_it_can_be():
    lost = Message("{why}", why=LOST)
    for status in ExitStatus:
        lines = lines_of(status, verbatim("why"), simulated=True, stored=True)
        assert lines[1] == "why" and lines[-1] == str(SIMULATED) and "Survey id: an-id" in lines
        resumable = status in (ExitStatus.STOPPED, ExitStatus.FAILED)
        assert any("run_survey --resume an-id" in line for line in lines) == resumable, status
    for status in (ExitStatus.PAUSED, ExitStatus.STOPPED, ExitStatus.FAILED):
        lines = lines_of(status, lost, stored=True)
        assert not any("--resume" in line for line in lines), status
        ends = any("stop_survey" in line for line in lines)
        assert ends == (status is ExitStatus.PAUSED)


def test_the_last_words_have_remedy_and_code_of_a_fault():
    paused = Outcome(ExitStatus.PAUSED, Message("Paused: {reason}.", reason=FULL))
    (step,) = [line for line in outcome_lines(paused, "", False) if line.details]
    assert step == first_step(FULL)
    assert step.values["remedy"] == DISK_FULL.remedy and step.details == "disk.full"
    asked = Outcome(ExitStatus.PAUSED, ASKED_PAUSE)
    assert not any("remedy" in line.values for line in outcome_lines(asked, "", False))


DAY_S = 86400


@given(st.integers(min_value=60, max_value=400 * DAY_S))
def test_a_time_is_rounded_up_by_less_than_its_last_unit(time_s):
    assert str(duration(-3)) == str(duration(59.9)) == "less than 1 min"
    words = str(duration(time_s))
    units = {"d": DAY_S, "h": 3600, "min": 60}
    parts = re.findall(r"(\d+) (d|h|min)", words)
    said_s = sum(int(number) * units[unit] for number, unit in parts)
    assert 0 <= said_s - time_s < units[parts[-1][1]]


def test_time_that_is_left_says_what_it_is_based_on():
    for visited, basis in ((0, "by the plan"), (1, "measured"), (12, "measured")):
        progress = Progress("id", 0.0, 18, visited, 1128.0)
        assert str(remaining(progress)) == f"19 min left ({basis})"


@pytest.fixture
def keyboard(monkeypatch):
    """Descriptor on which a test types; the question reads the other end."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "r") as stream:
        monkeypatch.setattr("sys.stdin", stream)
        yield ours
    os.close(ours)


@pytest.mark.needs("terminals")
def test_only_a_clear_yes_confirms(keyboard, capsys):
    for typed in ("y", "Yes", "s", "sí", "n", "", "x"):
        os.write(keyboard, f"{typed}\n".encode())
        confirmed = is_confirmed("Continue?", lambda: False)
        assert confirmed is (typed not in ("n", "", "x")), typed
        assert capsys.readouterr().out.startswith("Continue? ")

    assert not is_confirmed("Continue?", lambda: True)


def test_an_input_that_ends_is_no(monkeypatch):
    with open(os.devnull) as stream:
        monkeypatch.setattr("sys.stdin", stream)
        assert not is_confirmed("Continue?", lambda: False)


def show_progress(display, visited):
    progress = Progress("id", visited / 2.0, 200, visited, 200.0 - visited)
    display.show(progress, state_of(SurveyState.SURVEYING))


def test_plain_lines_come_every_ten_percent_and_at_the_end_in_the_language_of_the_terminal():
    stream = io.StringIO()
    display = PlainDisplay(stream, read_catalogue(Language.SPANISH))
    display.note(Message("permission denied", details="[Errno 13] '/data'"))
    for visited in (*range(196), 199, 200, 200):
        show_progress(display, visited)
    noted, *shown = stream.getvalue().splitlines()
    assert noted == "permiso denegado ([Errno 13] '/data')"
    assert shown[3] == " 30,0 %  60/200 trazas  quedan 3 min (según lo medido)"
    assert [one.split("%")[0].strip() for one in shown] == [f"{10 * one},0" for one in range(11)]


@each_case("columns", [80, 200])
def test_the_bar_carries_everything_within_the_width_of_the_terminal(monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    stream = io.StringIO()
    display = BarDisplay(stream, Catalogue())
    display.note(verbatim("SURVEYING: visiting"))
    show_progress(display, 50)
    display.close()
    text = stream.getvalue()
    assert "SURVEYING: visiting\n" in text and text.endswith("\n")
    last = text.rstrip("\n").split("\r")[-1]
    assert len(last) <= columns
    for part in ("SIMULATED SURVEYING", "25%", "50/200", "3 min left (measured)"):
        assert part in last
