"""Which points a survey visits, and in which order."""

import pytest
from case_kit import each_case
from cut_off_surveys import reopened_survey

from gpr20_main_control.mid.survey.survey_plan import RemainingTime
from gpr20_survey.plan.survey_state import SurveyState as State

TOTAL = 24


def visited(bench):
    """Return the indices of the points in the order in which the axes were sent to them."""
    shown = [one.target.index for one in bench.history if one.target is not None]
    return [one for one, before in zip(shown, [None, *shown]) if one != before]


def test_each_point_is_visited_in_the_order_of_the_plan(bench):
    bench.start()
    bench.complete()
    assert visited(bench) == list(range(TOTAL))


@pytest.mark.parametrize("stored", [[0, 2, 5, 23], list(range(TOTAL))])
def test_a_survey_from_the_disk_compares_its_last_stop_first_and_then_measures_what_is_missing(
    bench, stored
):
    bench.storage.reopened = reopened_survey(stored)
    for axis in bench.axes:
        axis.homed = True
        axis.begin_zero()
    bench.control.resume("survey")
    bench.wait_for(State.FINISHED)
    missing = [index for index in range(TOTAL) if index not in stored]
    assert visited(bench) == [max(stored), *missing]
    assert [one.index for one in bench.storage.samples] == missing
    assert [axis.homings for axis in bench.axes] == [1, 1, 1]


@each_case("done, spent_s, left_s", [(0, 5.0, 60.0), (1, 15.0, 75.0), (3, 90.0, 0.0)])
def test_the_remaining_time_is_the_plan_at_the_pace_so_far(done, spent_s, left_s):
    assert RemainingTime([10.0, 20.0, 30.0]).remaining_s(done, spent_s) == pytest.approx(left_s)
