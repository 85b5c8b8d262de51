"""The terminal client: its command line, how it follows a survey, and its lines."""

import contextlib
import io

import pytest
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st
from view_kit import LOST

from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import MAY_MOVE, NOT_RUNNING, PART_LOST
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_operator.plan.fields import PARAMETERS, PEOPLE
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL, Answer, ControlState, Progress, Request
from gpr20_survey.faults import CAN_RESUME, NONE_OPEN
from gpr20_survey.plan.survey_parameters import find_problems
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.terminal.follower import (
    TICK_S,
    Display,
    ExitStatus,
    StopRequested,
    SurveyFollower,
)
from gpr20_user_interface.terminal.survey_arguments import option_of, parse_arguments


def options_of(line):
    return parse_arguments(line.split(), Catalogue())


def test_the_defaults_can_be_run_and_assume_no_soil():
    options = options_of("")
    assert find_problems(options.plan.parameters, DOCUMENTED_TRAVEL) == []
    assert (options.plan.permittivity, options.resume) == (0.0, None)
    folder = "20260921T141320_0f8fad5b"
    for line, resume in (("--resume", ""), (f"--resume /data/{folder}/", folder)):
        assert options_of(line).resume == resume


def test_a_wrong_command_line_has_status_2_and_names_the_fault(capsys):
    for line, words in (
        ("--wait nan", "'nan' is not a number"),
        ("--wait -1", "S is -1 s; it must lie between 0 and 3600 s"),
        ("--position 91,0", "latitude is 91 deg; it must lie between -90 and 90 deg"),
        ("--resume --site=", "--site cannot be given with --resume"),
        ("--resume --permittivity 4", "--permittivity cannot be given with --resume"),
    ):
        with pytest.raises(SystemExit) as caught:
            options_of(line)
        assert caught.value.code == 2
        assert words in capsys.readouterr().err, line


@given(st.sampled_from((*PARAMETERS, *PEOPLE)), st.text(max_size=10))
def test_the_command_line_reads_what_the_window_reads_and_refuses_the_rest(spec, text):
    argument = f"{option_of(spec)}={text}"
    try:
        wanted = spec.kind.read(text)
    except InvalidValueError:
        with pytest.raises(SystemExit), contextlib.redirect_stderr(io.StringIO()):
            parse_arguments([argument], Catalogue())
        return
    plan = parse_arguments([argument], Catalogue()).plan
    record = plan.parameters if spec in PARAMETERS else plan.annotation
    assert getattr(record, spec.name) == wanted


def test_the_help_lists_fields_and_exit_statuses_in_the_language_of_the_catalogue(capsys):
    with pytest.raises(SystemExit) as caught:
        parse_arguments(["--help"], read_catalogue(Language.SPANISH))
    assert caught.value.code == 0
    text = capsys.readouterr().out
    assert all(f"\n  {status:>3}  " in text for status in (2, *map(int, ExitStatus)))
    for name in ("start-frequency-mhz", "x-start-mm", "averages", "permittivity", "notes"):
        assert f"\n  --{name} " in text
    assert "(por defecto 15)" in " ".join(text.split())


STARTED = Answer(Request.START, True, verbatim("started"), "ours")
RESUMED = Answer(Request.RESUME, True, verbatim("resumed"))
STOP = StopRequested("Ctrl-C")


def state(code, survey_id="ours", message="as it is"):
    said = verbatim(message) if isinstance(message, str) else message
    return ControlState(SurveyState[code], said, survey_id, True)


def progress(survey_id="ours", visited=9):
    return Progress(survey_id, visited / 0.18, 18, visited, 10.0)


BEGIN = (state("IDLE", ""), STARTED, state("SURVEYING"))


class Client:
    """The follower with its clock, what it has asked for, and what it has written."""

    def __init__(self, *events):
        self.clock, self.requests, self.stream = FakeClock(), [], io.StringIO()
        self.follower = SurveyFollower(
            *(lambda: self.requests.append("survey"), lambda: self.requests.append("stop")),
            *(Display(self.stream, Catalogue()), 10.0, self.clock),
        )
        self.say(*events)

    def say(self, *events):
        for event in events:
            if self.status is None:
                self.follower.take(event)
        return self

    def wait(self, seconds, spoken=None):
        """Let time pass; the main control may speak at each second."""
        for number in range(round(seconds / TICK_S)):
            self.clock.advance(TICK_S)
            if spoken is not None and number % 5 == 0:
                self.say(spoken)
            else:
                self.follower.look()
        return self

    @property
    def status(self):
        return self.follower.status

    @property
    def code(self):
        return self.follower.message.fault_code

    @property
    def lines(self):
        return self.stream.getvalue().splitlines()

    def last_words(self, *resumable):
        return "\n".join(map(str, self.follower.last_words(lambda: resumable)))


def test_a_survey_is_asked_for_once_when_the_main_control_is_heard():
    client = Client()
    assert client.requests == []
    client.say(state("IDLE", ""), state("CONFIGURED", ""), progress(""))
    # A long start is waited for.
    client.wait(600, state("HOMING"))
    assert (client.requests, client.status) == (["survey"], None)


def test_the_end_of_the_survey_is_the_exit_status_and_says_how_to_continue():
    for code, message, status, resumed in (
        ("FINISHED", "why", ExitStatus.FINISHED, False),
        ("FAILED", "why", ExitStatus.FAILED, True),
        ("FAILED", LOST, ExitStatus.FAILED, False),
        ("STOPPED", "why", ExitStatus.FAILED, True),
        ("PAUSED", "why", ExitStatus.PAUSED, True),
        ("PAUSED", LOST, ExitStatus.PAUSED, False),
    ):
        client = Client(*BEGIN, progress(), state(code, message=message))
        assert (client.status, client.requests) == (status, ["survey"])
        said = client.last_words()
        assert str(message) in said and "Survey id: ours" in said
        assert ("run_survey --resume ours" in said) is resumed, (code, message)


def test_the_end_of_a_former_survey_is_not_taken_for_ours_and_ours_is_not_missed():
    # The latched status says how the survey before this one ended.
    client = Client(state("FINISHED", "former"), STARTED, state("FINISHED", "former"))
    assert client.status is None
    client.say(state("CHECKING"), state("FAILED", message="VNA absent"))
    assert client.status is ExitStatus.FAILED
    # It ended before the answer came.
    client = Client(state("IDLE", ""), state("SURVEYING"), state("FINISHED"), STARTED)
    assert client.status is ExitStatus.FINISHED
    # A survey that is resumed was paused, or has ended, before.
    for former in ("PAUSED", "STOPPED", "FAILED"):
        client = Client(state(former), state(former), RESUMED, state(former))
        assert client.status is None, former
        client.say(state("CHECKING"), state("SURVEYING"), progress(), state("FINISHED"))
        assert client.status is ExitStatus.FINISHED and client.follower.survey_id == "ours"


def test_a_refusal_is_said_with_its_reason_and_names_what_can_be_resumed_if_none_is_open():
    refused = Answer(Request.RESUME, False, verbatim("the VNA is B, not A"), other_analyzer="B C")
    client = Client(state("PAUSED"), refused)
    assert (client.status, client.requests) == (ExitStatus.REFUSED, ["survey"])
    assert "the VNA is B, not A" in client.last_words("one")
    assert "--resume" not in client.last_words("one")
    none_open = Answer(Request.RESUME, False, verbatim("no survey").with_fault(NONE_OPEN))
    client = Client(state("IDLE", ""), none_open)
    said = client.last_words("one", "another")
    assert all(f"run_survey --resume {one}`" in said for one in ("one", "another"))
    assert "ARCHIVE" not in said, "a terminal has none"
    assert "--resume" not in client.last_words() and NONE_OPEN.code in client.last_words()


def test_silence_is_waited_for_within_its_limit_and_said():
    client = Client().wait(9)
    assert client.status is None
    assert client.wait(2).status is ExitStatus.REFUSED and client.code == NOT_RUNNING.code
    client = Client(*BEGIN).wait(6)
    assert client.status is None and "may still move" in "".join(client.lines[-2:])
    assert client.say(state("SURVEYING")).wait(30).status is None
    assert client.wait(11).status is ExitStatus.FAILED and client.code == PART_LOST.code
    # One that was restarted does not know the survey.
    client = Client(*BEGIN).wait(1, state("IDLE", ""))
    assert client.status is ExitStatus.FAILED and client.code in (PART_LOST.code, CAN_RESUME.code)
    assert "run_survey --resume ours" in client.last_words()
    # A client that was suspended itself has not heard anything.
    client = Client(*BEGIN)
    client.clock.advance(5000.0)
    client.follower.look()
    assert client.status is None


def test_ctrl_c_stops_the_survey_and_waits_for_its_end():
    assert Client(STOP).status is ExitStatus.STOPPED
    client = Client(*BEGIN, STOP)
    assert client.requests == ["survey", "stop"] and client.status is None
    client.say(state("STOPPING")).wait(50, state("STOPPING"))
    assert client.say(state("STOPPED")).status is ExitStatus.STOPPED
    assert Client(*BEGIN, STOP, state("FAILED")).status is ExitStatus.FAILED
    # What is not confirmed may move.
    client = Client(*BEGIN, STOP).wait(62, state("STOPPING"))
    assert client.status is ExitStatus.FAILED and client.code == MAY_MOVE.code
    # Before the answer: the survey begins all the same, and is stopped then; or it is withdrawn.
    client = Client(state("IDLE", ""), STOP, STARTED, state("CHECKING"))
    assert client.requests == ["survey", "stop", "stop"] and client.status is None
    withdrawn = Answer(Request.START, False, verbatim("withdrawn"))
    assert Client(state("IDLE", ""), STOP, withdrawn).status is ExitStatus.STOPPED
    # A STOP that nobody answers is repeated by a client that lives.
    client = Client(*BEGIN, STOP).wait(600)
    assert client.status is None
    assert client.wait(400).status is ExitStatus.FAILED


def test_a_state_is_said_once_per_change_and_a_warning_with_its_remedy_once():
    warped = Fault("mast.warped", verbatim("Straighten."), Severity.WARNING, may_move=True)

    def warns(number):
        message = Message("warped by {number} mm", number=number).with_fault(warped)
        return state("SURVEYING", message=message)

    client = Client(*BEGIN, state("SURVEYING"), warns(1), warns(2), progress("former"), progress())
    simulated, surveying, warning, step, half = client.lines
    assert simulated.startswith("SIMULATED") and surveying == "SURVEYING: as it is"
    assert warning == "SURVEYING: warped by 1 mm"
    hands_off = "Keep your hands clear: the robot may still move. Straighten."
    assert step == f"Do this first: {hands_off} (mast.warped)"
    assert half.startswith(" 50.0 %  9/18 traces")


def test_a_pipe_has_a_line_every_ten_percent_and_a_terminal_one_within_its_width(monkeypatch):
    stream = io.StringIO()
    display = Display(stream, read_catalogue(Language.SPANISH))
    for visited in (*range(196), 199, 200, 200):
        display.show(Progress("id", visited / 2.0, 200, visited, 200.0 - visited))
    shown = stream.getvalue().splitlines()
    assert shown[3] == " 30,0 %  60/200 trazas  quedan 3 min (según lo medido)"
    assert [one.split("%")[0].strip() for one in shown] == [f"{10 * one},0" for one in range(11)]
    monkeypatch.setenv("COLUMNS", "30")
    stream = io.StringIO()
    stream.isatty = lambda: True
    display = Display(stream, Catalogue())
    for visited in (1, 50):
        display.show(Progress("id", visited / 2.0, 200, visited, 200.0 - visited))
    display.note(verbatim("a\x1b[2J\nSurvey finished."))
    progress_line, noted = stream.getvalue().split("\n")[:2]
    assert noted == "a\\x1b[2J\\nSurvey finished."
    last = progress_line.split("\r")[-1].replace("\x1b[K", "")
    assert last.startswith(" 25.0 %  50/200") and len(last) < 30
