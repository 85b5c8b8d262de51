"""Interrupted surveys continue with exactly the points that are missing."""

import pytest
from cut_off_surveys import recorded_axes, reopened_survey
from fault_kit import raises_fault

from gpr20_main_control import faults
from gpr20_main_control.errors import SurveyError
from gpr20_survey.plan.survey_state import SurveyState as State


@pytest.mark.parametrize(
    "fault, stored, report, changes",
    [
        (faults.OTHER_ROBOT, [0, 1], "", {"simulated": False}),
        (faults.RECORD_DAMAGED, [0, 1], "", {"parameters": {}}),
        (faults.RECORD_DAMAGED, [0, 1], "", {"axes": {}}),
        (faults.OTHER_ROBOT, [0, 1], "", {"axes": recorded_axes(invert_direction=True)}),
        # It holds more than its plan.
        (faults.RECORD_DAMAGED, [0, 30], "", {}),
        (faults.RECORD_DAMAGED, [0], '{"controls": [{"index": 30}]}', {}),
        (faults.RECORD_DAMAGED, [0], '{"controls": [{"index": -1}]}', {}),
    ],
)
def test_a_survey_that_this_robot_cannot_go_on_with_is_refused_and_closed(
    bench, fault, stored, report, changes
):
    bench.storage.reopened = reopened_survey(stored, report, **changes)
    with raises_fault(fault, error=SurveyError) as refused:
        bench.control.resume("survey")
    assert not changes or "/data/survey" in str(refused.value)
    assert bench.board.status.state is State.IDLE
    assert bench.storage.ends[-1].outcome == "failed"
    assert bench.storage.ends[-1].status.state is State.FAILED
