from dataclasses import replace

import view_kit

from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.condition import left_of
from gpr20_operator.robot.events import Progress, TargetPosition
from gpr20_operator.robot.job import JobScreen, area_of, line_of, percent_of, survey_name
from gpr20_survey.plan.survey_state import ENDED, SurveyState

HALF = Progress("id", 59.99, 18, 9, 1080.0)


def snapshot(code=None, **other):
    return view_kit.snapshot(code, **{"progress": HALF, **other})


def test_time_is_left_only_while_it_passes():
    for code in SurveyState:
        left = left_of(snapshot(code))
        timed = ("CHECKING", "HOMING", "SURVEYING", "PAUSING")
        assert (str(left) == "18 min left") if code.name in timed else left is None, code


def test_a_percentage_is_rounded_down_and_only_of_this_survey():
    assert percent_of(snapshot(SurveyState.SURVEYING)) == 59
    assert percent_of(snapshot(SurveyState.FINISHED)) == 59
    other = view_kit.state_of(SurveyState.SURVEYING, survey_id="other")
    assert percent_of(snapshot(state=other)) is None
    assert percent_of(snapshot(SurveyState.CONFIGURED)) is None
    assert percent_of(snapshot(SurveyState.SURVEYING, progress=None)) is None


def test_the_line_is_that_of_the_target():
    for low, high in ((50.0, 130.0), (130.0, 50.0)):
        plan = replace(default_parameters(), y_start_mm=low, y_stop_mm=high, y_points=5)
        for number in range(5):
            target = TargetPosition(1.0, low + (high - low) * number / 4, 0.0)
            now = snapshot(SurveyState.SURVEYING, target=target, job_parameters=plan)
            assert str(line_of(now)) == f"line {number + 1} of 5"
        assert "80 mm" in str(area_of(plan))
        assert line_of(snapshot(SurveyState.PAUSED, job_parameters=plan)) is None


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


def test_a_name_is_read_from_a_description_whatever_it_holds():
    named = '{"survey_id": "7", "annotation": {"name": "A", "site": "B"}}'
    assert survey_name(named) == ("7", "A")
    assert survey_name('{"annotation": {"name": "", "site": "B"}}') == ("", "B")
    for text in ("", "{}", "[]", '{"annotation": null}', '{"annotation": {}}'):
        assert survey_name(text) == ("", "")
