"""The terminal client: its command line, how it follows a survey, and its lines."""

import contextlib
import io
import queue
from dataclasses import replace

import pytest
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st
from view_kit import ASKED_PAUSE, FULL, LOST

from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import DISK_FULL, MAY_MOVE, NOT_RUNNING, PART_LOST
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_operator import faults
from gpr20_operator.plan.fields import PARAMETERS, PEOPLE
from gpr20_operator.robot.events import (
    DOCUMENTED_TRAVEL,
    Answer,
    ControlState,
    Progress,
    Request,
    SenderIgnored,
    StopRequested,
)
from gpr20_survey.faults import NONE_OPEN
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_parameters import find_problems
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_user_interface.terminal.follower import TICK_S, Display, ExitStatus, SurveyFollower
from gpr20_user_interface.terminal.survey_arguments import (
    option_of,
    parse_arguments,
)


def options_of(line):
    return parse_arguments(line.split(), Catalogue())


def test_defaults_are_a_survey_that_can_be_run():
    options = options_of("")
    assert find_problems(options.parameters, DOCUMENTED_TRAVEL) == []
    assert options.parameters.vna_address == ""
    assert options.parameters.sweep_settings.analyzer == AnalyzerSettings()
    assert options.permittivity == 0.0 and options.annotation == EMPTY
    assert options.resume is None and not options.attach


def test_a_survey_that_exists_can_be_followed():
    assert options_of("--attach").attach
    for line, resume, analyzer in (
        ("--resume --accept-analyzer A,B/2", "", "A,B/2"),
        ("--resume 1234", "1234", ""),
        ("--resume /data/20260921T141320_0f8fad5b/", "20260921T141320_0f8fad5b", ""),
    ):
        options = options_of(line)
        assert (options.resume, options.accept_analyzer) == (resume, analyzer)


WRONG = (
    ("--x-points three", "three"),
    ("--wait nan", "'nan' is not a number"),
    ("--polarizations-deg 0,x", "0,x"),
    ("--attach --resume", "not allowed with"),
    ("--attach --y-stop 9 --polar 0", "--y-stop-mm, --polarizations-deg cannot be given with"),
    ("--position 91,0", "latitude is 91 deg; it must lie between -90 and 90 deg"),
    ("--resume --site=", "--site cannot be given with --resume"),
    ("--permittivity 0.5", "'0.5' is no permittivity of a soil"),
    ("--resume --permittivity 4", "--permittivity cannot be given with --resume"),
    ("--attach --accept-zeros", "only with --resume"),
    ("--accept-analyzer B", "only with --resume"),
)


def test_a_wrong_command_line_has_status_2_and_names_the_fault(capsys):
    for line, words in WRONG:
        with pytest.raises(SystemExit) as caught:
            options_of(line)
        assert caught.value.code == 2
        assert words in capsys.readouterr().err, line


@given(st.sampled_from((*PARAMETERS, *PEOPLE)), st.text(max_size=10))
def test_the_command_line_reads_what_the_window_reads_and_refuses_the_rest(spec, text):
    try:
        wanted = spec.kind.read(text)
    except InvalidValueError:
        with pytest.raises(SystemExit), contextlib.redirect_stderr(io.StringIO()):
            parse_arguments([f"{option_of(spec)}={text}"], Catalogue())
        return
    given_ = parse_arguments([f"{option_of(spec)}={text}"], Catalogue())
    record = given_.parameters if spec in PARAMETERS else given_.annotation
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


def state(code, survey_id="ours", message="as it is"):
    said = verbatim(message) if isinstance(message, str) else message
    return ControlState(SurveyState[code], said, survey_id, True)


def progress(survey_id="ours", visited=9):
    return Progress(survey_id, visited / 0.18, 18, visited, 10.0)


BEGIN = (state("IDLE", ""), STARTED, state("SURVEYING"))


class Client:
    """The follower with its clock, what it has asked for, and what it has written."""

    def __init__(self, *events, attach=False):
        self.clock, self.requests, self.stream = FakeClock(), [], io.StringIO()
        self.follower = SurveyFollower(
            None if attach else lambda: self.requests.append("survey"),
            *(lambda: self.requests.append("stop"), Display(self.stream, Catalogue())),
            *(10.0, self.clock),
        )
        self.say(*events)

    def say(self, *events):
        for event in events:
            if self.follower.outcome is None:
                self.follower.take(event)
        return self

    def wait(self, seconds, spoken=None):
        """Let time pass; the main control may speak at each second."""
        for number in range(round(seconds / TICK_S)):
            self.clock.advance(TICK_S)
            if spoken is not None and number % 5 == 0:
                self.say(spoken)
            elif self.follower.outcome is None:
                self.follower.tick()
        return self

    @property
    def status(self):
        return None if self.follower.outcome is None else self.follower.outcome.status

    @property
    def message(self):
        return self.follower.outcome.message

    @property
    def lines(self):
        return self.stream.getvalue().splitlines()


def test_a_survey_is_asked_for_once_when_the_main_control_is_heard():
    client = Client()
    assert client.requests == []
    client.say(state("IDLE", ""), state("CONFIGURED", ""), progress(""))
    # A long start is waited for.
    client.wait(600, state("HOMING"))
    assert (client.requests, client.status) == (["survey"], None)


def test_the_end_of_the_survey_is_the_outcome_with_its_words():
    for code, status in (
        ("FINISHED", ExitStatus.FINISHED),
        ("FAILED", ExitStatus.FAILED),
        ("STOPPED", ExitStatus.FAILED),
        ("PAUSED", ExitStatus.PAUSED),
    ):
        client = Client(*BEGIN, state(code, message="why"))
        assert (client.status, str(client.message)) == (status, "why")
        assert client.requests == ["survey"]
    # Another plan that is set hides it.
    for end in (SurveyState.FINISHED, SurveyState.FAILED):
        client = Client(*BEGIN, replace(state("CONFIGURED"), end=end))
        assert (client.status.name, str(client.message)) == (end.name, end.name)


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


def test_a_refusal_is_said_with_its_reason_and_nothing_is_accepted_by_itself():
    refused = Answer(Request.RESUME, False, verbatim("the VNA is B, not A"), other_analyzer="B C")
    client = Client(state("PAUSED"), refused)
    assert (client.status, str(client.message)) == (ExitStatus.REFUSED, "the VNA is B, not A")
    assert client.requests == ["survey"]
    assert any("--accept-analyzer 'B C'" in str(one) for one in client.follower.last_words())
    client = Client(state("STOPPED"), attach=True)
    assert client.status is ExitStatus.REFUSED and client.message.fault == NONE_OPEN


def test_an_absent_main_control_is_waited_for_within_the_limit():
    client = Client().wait(9)
    assert client.status is None
    assert client.wait(2).status is ExitStatus.REFUSED and client.message.fault == NOT_RUNNING
    # Where a replay plays there is no robot.
    client = Client(SenderIgnored("/play")).wait(11)
    assert client.status is ExitStatus.REFUSED and client.message.fault == faults.REPLAY
    # Nor a survey of which nothing is said.
    client = Client(state("IDLE", ""), STARTED).wait(11, state("IDLE", ""))
    assert client.status is ExitStatus.FAILED and client.message.fault == PART_LOST


def test_a_lost_main_control_is_said_and_not_waited_for_without_a_limit():
    client = Client(*BEGIN).wait(6)
    assert client.status is None and "may still move" in client.lines[-1]
    assert client.say(state("SURVEYING")).wait(30).status is None
    assert client.wait(10).status is ExitStatus.FAILED
    assert client.message.fault == PART_LOST and client.message.may_move
    # One that was restarted does not know the survey.
    client = Client(*BEGIN, state("IDLE", ""))
    assert client.status is ExitStatus.FAILED and client.message.fault == PART_LOST
    # A client that was suspended itself has not heard anything.
    client = Client(*BEGIN)
    client.clock.advance(5000.0)
    client.follower.tick()
    assert client.status is None


def test_ctrl_c_stops_the_survey_and_waits_for_its_end():
    stop = StopRequested("Ctrl-C")
    assert Client(stop).status is ExitStatus.STOPPED
    client = Client(*BEGIN, stop)
    assert client.requests == ["survey", "stop"] and client.status is None
    client.say(state("STOPPING")).wait(50, state("STOPPING"))
    assert client.say(state("STOPPED")).status is ExitStatus.STOPPED
    # One that came before there was anything to stop is asked again.
    client = Client(*BEGIN, stop, Answer(Request.STOP, False, verbatim("no survey runs")))
    client.say(state("SURVEYING"), state("SURVEYING"))
    assert client.requests == ["survey", "stop", "stop"]
    # What is not confirmed may move.
    client = Client(*BEGIN, stop).wait(62, state("STOPPING"))
    assert client.status is ExitStatus.FAILED and client.message.fault == MAY_MOVE
    # Before the answer: the survey begins all the same, and is stopped then; or it is withdrawn.
    client = Client(state("IDLE", ""), stop, STARTED)
    assert client.requests == ["survey", "stop", "stop"] and client.status is None
    withdrawn = Answer(Request.START, False, verbatim("withdrawn"))
    assert Client(state("IDLE", ""), stop, withdrawn).status is ExitStatus.STOPPED
    # A STOP that nobody answers is repeated by a client that lives.
    client = Client(*BEGIN, stop).wait(600)
    assert client.status is None
    assert client.wait(400).status is ExitStatus.FAILED


def test_a_state_is_said_once_per_change_and_a_warning_with_its_remedy_once():
    warped = Fault("mast.warped", verbatim("Straighten."), Severity.WARNING, may_move=True)

    def warns(number):
        message = Message("warped by {number} mm", number=number).with_fault(warped)
        return state("SURVEYING", message=message)

    client = Client(*BEGIN, state("SURVEYING"), warns(1), warns(2), progress("former"), progress())
    simulated, surveying, one, step, two, half = client.lines
    assert simulated.startswith("SIMULATED") and surveying == "SURVEYING: as it is"
    assert (one, two) == ("SURVEYING: warped by 1 mm", "SURVEYING: warped by 2 mm")
    hands_off = "Keep your hands clear: the robot may still move. Straighten."
    assert step == f"Do this first: {hands_off} (mast.warped)"
    assert half.startswith(" 50.0 %  9/18 traces")


def test_the_last_words_say_how_a_survey_that_ended_early_is_resumed_if_it_can_be():
    for code, message, how in (
        ("PAUSED", "why", "run_survey --resume ours"),
        ("PAUSED", LOST, "stop_survey"),
        ("FAILED", "why", "run_survey --resume ours"),
        ("FAILED", LOST, ""),
        ("FINISHED", "why", ""),
    ):
        client = Client(*BEGIN, progress(), state(code, message=message))
        words = [str(one) for one in client.follower.last_words()]
        assert "Survey id: ours" in words
        found = [one for one in words if "run_survey" in one or "stop_survey" in one]
        assert how in found[-1] if how else not found, (code, words)


def test_the_last_words_have_remedy_and_code_of_a_fault():
    message = Message("Paused: {reason}.", reason=FULL)
    client = Client(*BEGIN, state("PAUSED", message=message))
    (step,) = [one for one in client.follower.last_words() if one.details]
    assert step.values["remedy"] == DISK_FULL.remedy and step.details == "disk.full"
    client = Client(*BEGIN, state("PAUSED", message=ASKED_PAUSE))
    assert not any("remedy" in one.values for one in client.follower.last_words())


def test_events_are_taken_until_there_is_an_outcome():
    events = queue.SimpleQueue()
    for event in (*BEGIN, progress(), state("FINISHED"), state("FAILED")):
        events.put(event)
    assert Client().follower.run(events).status is ExitStatus.FINISHED


def test_lines_of_a_pipe_come_every_ten_percent_and_at_the_end_in_its_language():
    stream = io.StringIO()
    display = Display(stream, read_catalogue(Language.SPANISH))
    display.note(Message("permission denied", details="[Errno 13] '/data'"))
    for visited in (*range(196), 199, 200, 200):
        display.show(Progress("id", visited / 2.0, 200, visited, 200.0 - visited))
    noted, *shown = stream.getvalue().splitlines()
    assert noted == "permiso denegado ([Errno 13] '/data')"
    assert shown[3] == " 30,0 %  60/200 trazas  quedan 3 min (según lo medido)"
    assert [one.split("%")[0].strip() for one in shown] == [f"{10 * one},0" for one in range(11)]


def test_a_terminal_has_one_line_of_progress_within_its_width(monkeypatch):
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
