"""Interrupted surveys continue with exactly the points that are missing."""

import pytest
from cut_off_surveys import recorded_axes, reopened_survey
from fault_kit import raises_fault

from gpr20_main_control import faults
from gpr20_main_control.errors import RequestRefusedError, SurveyError
from gpr20_survey.plan.survey_state import SurveyState as State


def test_a_survey_of_a_version_that_knew_fewer_parameters_of_an_axis_is_resumed(bench):
    later = (
        *("homing_margin", "endstop_active", "endstop_pull"),
        *("invert_direction", "enable_pin", "enable_active"),
    )
    bench.storage.reopened = reopened_survey([0], axes=recorded_axes(without=later))
    bench.control.resume("survey")
    bench.wait_for(State.FINISHED)
    assert [sample.index for sample in bench.storage.samples] == list(range(1, 24))


@pytest.mark.parametrize(
    "changes, fault",
    [
        ({"simulated": False}, faults.OTHER_ROBOT),
        ({"parameters": {}}, faults.RECORD_DAMAGED),
        ({"axes": {}}, faults.OTHER_AXES),
        ({"axes": recorded_axes(invert_direction=True)}, faults.OTHER_AXES),
    ],
)
def test_a_survey_that_this_robot_cannot_go_on_with_is_refused_and_closed(bench, changes, fault):
    bench.storage.reopened = reopened_survey([0, 1], **changes)
    with raises_fault(fault, "/data/survey", error=RequestRefusedError):
        bench.control.resume("survey")
    assert bench.board.status.state is State.IDLE
    assert bench.storage.ends[-1].outcome == "failed"
    assert bench.storage.ends[-1].status.state is State.FAILED


@pytest.mark.parametrize(
    "stored, report",
    [([0, 30], ""), ([0], '{"controls": [{"index": 30}]}'), ([0], '{"controls": [{"index": -1}]}')],
)
def test_a_survey_that_holds_more_than_its_plan_is_refused_and_closed(bench, stored, report):
    bench.storage.reopened = reopened_survey(stored, report)
    with raises_fault(faults.RECORD_DAMAGED, error=SurveyError):
        bench.control.resume("survey")
    assert bench.board.status.state is State.IDLE
    assert bench.storage.ends[-1].outcome == "failed"
