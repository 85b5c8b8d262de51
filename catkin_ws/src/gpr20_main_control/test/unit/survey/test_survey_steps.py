"""The list of steps of a survey; they are not executed."""

import pytest
from case_kit import each_case
from cut_off_surveys import reopened_survey, stored_trace
from survey_examples import AXES, PARAMETERS

from gpr20_main_control.mid.survey.survey_plan import RemainingTime, plan_resumption, plan_survey
from gpr20_main_control.mid.survey.survey_steps import (
    Check,
    Checkpoint,
    Compare,
    Confirm,
    Finish,
    Home,
    Move,
    Open,
    Settle,
    SurveyProgress,
    Sweep,
    survey_steps,
)
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveySettings

CONFIG = RobotConfig(AXES, simulated=True)
PLAN = plan_survey(PARAMETERS, CONFIG, SurveySettings())
TOTAL = 24


def resumed_plan(stored):
    return plan_resumption(reopened_survey(stored), CONFIG, SurveySettings())


def run(plan, progress=None):
    """Yield the steps, executing them in name: each sweep is confirmed."""
    progress = progress or SurveyProgress(plan)
    for step in survey_steps(plan, progress):
        yield step
        if isinstance(step, Sweep):
            progress.note_swept()
        elif isinstance(step, Confirm):
            progress.note_confirmed(stored_trace(step.point.index))


def steps_of(plan, progress=None):
    return list(run(plan, progress))


def indices(steps, kind):
    return [step.point.index for step in steps if isinstance(step, kind)]


def test_each_point_is_moved_to_and_measured_in_the_order_of_the_plan():
    steps = [step for step in steps_of(PLAN) if not isinstance(step, Confirm)]
    assert steps == [
        *(Check(), Open(), Home(every_axis=False)),
        *(
            step
            for point in PLAN.points
            for step in (Checkpoint(), Move(point), Settle(point), Sweep(point))
        ),
        Finish(),
    ]


def test_a_sweep_is_confirmed_after_the_next_move_and_before_the_next_sweep():
    steps = steps_of(PLAN)[3:-1]
    assert indices(steps, Confirm) == list(range(TOTAL))
    for before, step, after in zip(steps, steps[1:], steps[2:]):
        if isinstance(step, Confirm):
            assert isinstance(before, Settle) and before.point.index == step.point.index + 1
            assert after == Sweep(before.point)
    assert steps[-1] == Confirm(PLAN.points[-1])


@pytest.mark.parametrize("stored", [[], [0, 2, 5, 23], list(range(TOTAL))])
def test_a_survey_from_the_disk_compares_its_last_stop_first_and_then_measures_what_is_missing(
    stored,
):
    steps = steps_of(resumed_plan(stored))
    missing = [index for index in range(TOTAL) if index not in stored]
    assert steps[2] == Home(every_axis=True)
    compared = [step.stored for step in steps if isinstance(step, Compare)]
    assert [one[-1].index for one in compared] == ([max(stored)] if stored else [])
    if stored:
        assert isinstance(steps[3], Compare)
    for kind in (Move, Settle, Sweep, Confirm):
        assert indices(steps, kind) == missing


@pytest.mark.parametrize("homed", [False, True])
def test_a_known_point_is_compared_only_if_the_zeros_are_other_ones(homed):
    progress = SurveyProgress(PLAN)
    progress.note_swept()
    progress.note_confirmed(stored_trace(0))
    steps = []
    for step in run(PLAN, progress):
        steps.append(step)
        if isinstance(step, Home):
            progress.note_homed(compare=homed)
    compared = [step.stored for step in steps if isinstance(step, Compare)]
    assert [[one.index for one in stored] for stored in compared] == ([[0]] if homed else [])
    assert indices(steps, Sweep) == list(range(1, TOTAL))


@each_case("done, spent_s, left_s", [(0, 5.0, 60.0), (1, 15.0, 75.0), (3, 90.0, 0.0)])
def test_the_remaining_time_is_the_plan_at_the_pace_so_far(done, spent_s, left_s):
    assert RemainingTime([10.0, 20.0, 30.0]).remaining_s(done, spent_s) == pytest.approx(left_s)
