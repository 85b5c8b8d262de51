import pytest
from test_fault_messages import CLOCK, MOVING, paused

from gpr20_common.message import Message, verbatim
from gpr20_survey.plan.survey_state import ENDED, SurveyState
from gpr20_user_interface.mid.events import ControlState, Progress, TargetPosition
from gpr20_user_interface.mid.job import JobLevel, JobScreen, area_of, job_of
from gpr20_user_interface.mid.parameter_form import default_parameters
from gpr20_user_interface.mid.robot_health import Alarm, AlarmKind
from gpr20_user_interface.mid.survey_model import Snapshot

HALF = Progress("id", 59.99, 18, 9, 1080.0)


def snapshot(code=None, message="as it is", survey_id="id", **other):
    state = None if code is None else ControlState(code, verbatim(message), survey_id, True)
    values = {
        "control_alive": True,
        "control_silent_s": 0.1,
        "state": state,
        "progress": HALF,
        "current": None,
        "target": None,
        "height_m": None,
        "pending": frozenset(),
        "travel": None,
    }
    return Snapshot(**{**values, **other})


@pytest.mark.parametrize("code", list(SurveyState))
def test_time_is_left_only_while_it_passes(code):
    left = job_of(snapshot(code)).left
    timed = ("CHECKING", "HOMING", "SURVEYING", "PAUSING")
    assert (str(left) == "18 min left") if code.name in timed else left is None


@pytest.mark.parametrize("code", [SurveyState.PAUSED, SurveyState.FAILED])
def test_a_survey_that_does_not_go_on_has_another_level_than_one_that_does(code):
    working = job_of(snapshot(SurveyState.SURVEYING))
    assert working.level is JobLevel.WORKING
    other = job_of(snapshot(code))
    assert other.level is not JobLevel.WORKING and other.title != working.title


def test_a_percentage_is_rounded_down_and_only_of_this_survey():
    assert job_of(snapshot(SurveyState.SURVEYING)).percent == 59
    assert job_of(snapshot(SurveyState.FINISHED)).percent == 59
    assert job_of(snapshot(SurveyState.SURVEYING, survey_id="other")).percent is None
    assert job_of(snapshot(SurveyState.CONFIGURED)).percent is None
    assert job_of(snapshot(SurveyState.SURVEYING, progress=None)).percent is None


def test_a_warning_comes_before_the_time():
    state = ControlState(
        SurveyState.SURVEYING,
        Message("Warning: {warning}. {status}", warning=CLOCK.as_warning(), status=verbatim("on")),
        "id",
        True,
    )
    job = job_of(snapshot(SurveyState.SURVEYING, **{"state": state}))
    assert job.left is None and str(job.message) == "Warning: the clock is late. on"


@pytest.mark.parametrize("kind", list(AlarmKind))
def test_an_alarm_is_never_shown_as_work(kind):
    job = job_of(snapshot(SurveyState.SURVEYING, alarm=Alarm(kind, 7.0, verbatim("x"))))
    assert job.level is not JobLevel.WORKING and job.left is None
    assert job.message == Alarm(kind, 7.0, verbatim("x")).message


def test_a_stop_with_a_fault_is_a_fault():
    assert job_of(snapshot(SurveyState.STOPPED)).level is JobLevel.REST
    state = ControlState(SurveyState.STOPPED, MOVING, "id", True)
    assert job_of(snapshot(SurveyState.STOPPED, state=state)).level is JobLevel.FAULT


def test_nothing_is_claimed_before_there_is_a_state():
    job = job_of(snapshot(alarm=Alarm(AlarmKind.NO_CONTROL)))
    assert (job.level, job.percent, job.left, job.line) == (JobLevel.FAULT, None, None, None)


@pytest.mark.parametrize("reverse", [False, True])
def test_the_line_is_that_of_the_target(reverse):
    low, high = (130.0, 50.0) if reverse else (50.0, 130.0)
    parameters = default_parameters()
    parameters = type(parameters)(
        **{**vars(parameters), "y_start_mm": low, "y_stop_mm": high, "y_points": 5}
    )
    for number in range(5):
        y_mm = low + (high - low) * number / 4
        now = snapshot(
            SurveyState.SURVEYING,
            target=TargetPosition(1.0, y_mm, 0.0),
            job_parameters=parameters,
        )
        assert str(job_of(now).line) == f"line {number + 1} of 5"
    assert "80 mm" in str(area_of(parameters))
    assert job_of(snapshot(SurveyState.PAUSED, job_parameters=parameters)).line is None


def test_the_job_stays_until_the_next_survey_is_planned():
    screen = JobScreen()
    for code in (SurveyState.IDLE, SurveyState.CONFIGURED):
        screen.note(snapshot(code))
        assert not screen.visible
    for code in (SurveyState.CHECKING, SurveyState.SURVEYING, SurveyState.PAUSED):
        screen.note(snapshot(code))
        screen.leave(snapshot(code))
        assert screen.visible, "a running survey cannot be left"
    for code in ENDED:
        screen.note(snapshot(code))
        assert screen.visible
    ended = snapshot(SurveyState.FINISHED)
    screen.leave(ended)
    screen.note(ended)
    assert not screen.visible
    # The same survey, resumed.
    screen.note(snapshot(SurveyState.SURVEYING))
    screen.note(ended)
    assert screen.visible


def test_a_paused_survey_says_why():
    fault = paused(Message("the disk is full"))
    assert "the disk is full" in str(job_of(snapshot(SurveyState.PAUSED, state=fault)).message)
