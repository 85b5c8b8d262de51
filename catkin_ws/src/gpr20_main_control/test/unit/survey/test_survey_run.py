"""A whole survey over a fake robot: its order, its requests, its end."""

import pytest
from fake_robot import Bench
from fault_kit import raises_fault
from survey_examples import PARAMETERS, TRAVEL

from gpr20_main_control import faults
from gpr20_main_control.errors import RequestRefusedError
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.plan.survey_state import SurveyState as State


def test_a_survey_stores_every_point_exactly_once_and_finishes(bench):
    x_points = 4
    bench.start(x_points=x_points)
    status = bench.wait_for(State.FINISHED)
    total = x_points * 4 * 2
    assert [sample.index for sample in bench.storage.samples] == list(range(total))
    places = {(s.x_coord_mm, s.y_coord_mm, s.z_coord_deg) for s in bench.storage.samples}
    assert len(places) == total
    assert len({sample.sample_id for sample in bench.storage.samples}) == total
    assert status.completion_percent == 100.0
    assert status.remaining_s == 0.0
    assert bench.states == ["CONFIGURED", "CHECKING", "HOMING", "SURVEYING", "FINISHED"]
    assert [outcome for _id, outcome, _reason in bench.storage.closed] == ["finished"]
    # The recordings end with the status that is published.
    assert bench.storage.ends[-1].status == status
    assert bench.storage.ends[-1].coverage.verdict().complete


def test_requests_that_do_not_fit_the_state_are_refused_with_the_reason(bench):
    with raises_fault(faults.NO_PLAN, error=RequestRefusedError):
        bench.control.start()
    with raises_fault(faults.NONE_RUNNING, error=RequestRefusedError):
        bench.control.stop()
    with raises_fault(faults.NONE_PAUSED, error=RequestRefusedError):
        bench.control.resume("")
    bench.storage.free.clear()
    bench.start()
    for request in (bench.control.start, lambda: bench.start(x_points=4)):
        with raises_fault(faults.SURVEY_IN_PROGRESS, error=RequestRefusedError):
            request()
    bench.storage.free.set()
    bench.wait_for(State.FINISHED)


def test_the_target_is_shown_while_a_survey_runs_and_only_then(bench):
    bench.start()
    bench.wait_for(State.FINISHED)
    planned = survey_points(PARAMETERS, TRAVEL)
    shown = [status.target for status in bench.history if status.target is not None]
    assert set(planned) == set(shown)
    assert bench.board.status.target is None


def test_the_estimate_follows_the_speed_of_the_robot():
    real = Bench(settle_s=1.0).control.set_parameters(PARAMETERS)
    fast = Bench(time_scale=50.0, settle_s=1.0).control.set_parameters(PARAMETERS)
    assert real.total_points == fast.total_points == 24
    assert real.duration_s == pytest.approx(50.0 * fast.duration_s)
    assert real.duration_s > 24 * 1.0
