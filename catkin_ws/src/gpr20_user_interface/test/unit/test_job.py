from dataclasses import replace

import view_kit
from test_fault_messages import CLOCK, MOVING, paused

from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.parameter_form import default_parameters
from gpr20_operator.robot.events import ControlState, Progress, TargetPosition
from gpr20_operator.robot.health import Alarm, AlarmKind
from gpr20_operator.robot.job import JobLevel, JobScreen, area_of, job_of
from gpr20_survey.plan.survey_state import ENDED, SurveyState

ON = verbatim("on")
HALF = Progress("id", 59.99, 18, 9, 1080.0)


def snapshot(code=None, **other):
    return view_kit.snapshot(code, **{"progress": HALF, **other})


def test_time_is_left_only_while_it_passes():
    for code in SurveyState:
        left = job_of(snapshot(code)).left
        timed = ("CHECKING", "HOMING", "SURVEYING", "PAUSING")
        assert (str(left) == "18 min left") if code.name in timed else left is None, code


def test_a_survey_that_does_not_go_on_has_another_level_than_one_that_does():
    working = job_of(snapshot(SurveyState.SURVEYING))
    assert working.level is JobLevel.WORKING
    for code in (SurveyState.PAUSED, SurveyState.FAILED):
        other = job_of(snapshot(code))
        assert other.level is not JobLevel.WORKING and other.title != working.title


def test_a_percentage_is_rounded_down_and_only_of_this_survey():
    assert job_of(snapshot(SurveyState.SURVEYING)).percent == 59
    assert job_of(snapshot(SurveyState.FINISHED)).percent == 59
    other = view_kit.state_of(SurveyState.SURVEYING, survey_id="other")
    assert job_of(snapshot(state=other)).percent is None
    assert job_of(snapshot(SurveyState.CONFIGURED)).percent is None
    assert job_of(snapshot(SurveyState.SURVEYING, progress=None)).percent is None


def test_a_warning_comes_before_the_time():
    warning = Message("Warning: {warning}. {status}", warning=CLOCK.as_warning(), status=ON)
    state = ControlState(SurveyState.SURVEYING, warning, "id", True)
    job = job_of(snapshot(state=state))
    assert job.left is None and str(job.message) == "Warning: the clock is late. on"


def test_an_alarm_is_never_shown_as_work():
    for kind in AlarmKind:
        alarm = Alarm(kind, 7.0, verbatim("x"))
        job = job_of(snapshot(SurveyState.SURVEYING, alarm=alarm))
        assert job.level is not JobLevel.WORKING and job.left is None, kind
        assert job.message == alarm.message
    job = job_of(snapshot(alarm=Alarm(AlarmKind.NO_CONTROL)))
    assert (job.level, job.percent, job.left, job.line) == (JobLevel.FAULT, None, None, None)


def test_a_stop_with_a_fault_is_a_fault():
    assert job_of(snapshot(SurveyState.STOPPED)).level is JobLevel.REST
    state = ControlState(SurveyState.STOPPED, MOVING, "id", True)
    assert job_of(snapshot(SurveyState.STOPPED, state=state)).level is JobLevel.FAULT


def test_the_line_is_that_of_the_target():
    for low, high in ((50.0, 130.0), (130.0, 50.0)):
        plan = replace(default_parameters(), y_start_mm=low, y_stop_mm=high, y_points=5)
        for number in range(5):
            target = TargetPosition(1.0, low + (high - low) * number / 4, 0.0)
            now = snapshot(SurveyState.SURVEYING, target=target, job_parameters=plan)
            assert str(job_of(now).line) == f"line {number + 1} of 5"
        assert "80 mm" in str(area_of(plan))
        assert job_of(snapshot(SurveyState.PAUSED, job_parameters=plan)).line is None


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
