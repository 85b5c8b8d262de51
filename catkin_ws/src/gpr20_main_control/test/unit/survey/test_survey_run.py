"""A whole survey over a fake robot: its order, its requests, its pauses, its end."""

import threading
from dataclasses import replace

import pytest
from cut_off_surveys import recorded_axes, reopened_survey
from fake_robot import LIMIT_S, reports
from fault_kit import raises_fault
from survey_examples import PARAMETERS

from gpr20_common.message import Message
from gpr20_main_control.errors import OTHER_ROBOT, RECORD_DAMAGED, DeviceError, SurveyError
from gpr20_main_control.mid.survey.survey import Accepted
from gpr20_survey.faults import STOPPED, TAKES_LONG
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_state import SurveyState as State


def test_a_survey_stores_every_point_exactly_once_and_finishes(bench):
    plan = bench.control.set_parameters(replace(PARAMETERS, x_points=4))
    bench.control.start()
    status = bench.wait_for(State.FINISHED)
    samples, total = bench.storage.samples, 4 * 4 * 2
    assert [sample.index for sample in samples] == list(range(total))
    assert len({(s.x_coord_mm, s.y_coord_mm, s.z_coord_deg) for s in samples}) == total
    assert len({sample.sample_id for sample in samples}) == total
    assert (status.visited_points, status.remaining_s) == (total, 0.0)
    left_s = {one.visited_points: one.remaining_s for one in bench.history if one.total_points}
    assert len(left_s) == total + 1 and sorted(left_s.values(), reverse=True) == [*left_s.values()]
    assert left_s[0] == pytest.approx(plan.duration_s)
    assert bench.states == ["CONFIGURED", "CHECKING", "HOMING", "SURVEYING", "FINISHED"]
    assert [one.outcome for one in bench.storage.ends] == ["finished"]
    # The recordings end with the status that is published.
    assert bench.storage.ends[-1].status == status
    assert bench.storage.ends[-1].coverage.verdict().complete
    assert [one.complete for one in bench.verdicts].index(True) == len(bench.verdicts) - 1
    shown = {one.target for one in bench.history if one.target is not None}
    assert len(shown) == total and status.target is None
    assert visited(bench) == list(range(total))
    # Told when they are set and when the survey begins.
    assert [one.x_points for one in bench.parameters] == [4, 4]


def test_the_height_of_every_trace_is_the_one_measured_at_its_own_point(bench):
    def ground_below():
        return 0.1 + bench.x.coordinate / 1000.0 + bench.y.coordinate / 100.0

    bench.height.height_m = ground_below
    bench.start()
    bench.complete()
    for one in bench.storage.samples:
        expected_m = 0.1 + one.x_coord_mm / 1000.0 + one.y_coord_mm / 100.0
        assert one.antennae_height_m == pytest.approx(expected_m)
    assert len({one.antennae_height_m for one in bench.storage.samples}) == 12


# Pauses.


def test_a_pause_its_end_and_what_the_operator_accepted_are_noted_in_their_order(bench):
    bench.at_sweep(2, bench.control.pause)
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.control.resume("", Accepted(zeros=True))
    bench.complete()
    notes = bench.storage.notes
    assert [one.kind for one in notes] == [Kind.EPOCH, Kind.PAUSE, Kind.DECISION, Kind.CONTINUE]
    assert notes[1].values["message"]["code"] == STOPPED.code
    assert notes[2].values["zeros"] is True
    assert all(one.values["time"] for one in notes)


def test_a_fact_that_could_not_be_stored_waits_and_keeps_its_place(bench):
    add_fact, refused = bench.storage.add_fact, []

    def refuse_once(survey_id, kind, values_json):
        if kind is Kind.EPOCH and not refused:
            refused.append(kind)
            raise DeviceError(Message("the disk is full"))
        return add_fact(survey_id, kind, values_json)

    bench.storage.add_fact = refuse_once
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.resume_to_the_end()
    kinds = [one.kind for one in bench.storage.notes]
    assert refused and kinds == [Kind.EPOCH, Kind.PAUSE, Kind.CONTINUE, Kind.EPOCH]


# From the disk.

TOTAL = 24


def visited(bench):
    """Return the indices of the points in the order in which the axes were sent to them."""
    shown = [one.target.index for one in bench.history if one.target is not None]
    return [one for one, before in zip(shown, [None, *shown]) if one != before]


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


@pytest.mark.parametrize(
    "fault, stored, report, changes",
    [
        (OTHER_ROBOT, [0, 1], "", {"simulated": False}),
        (RECORD_DAMAGED, [0, 1], "", {"parameters": {}}),
        (RECORD_DAMAGED, [0, 1], "", {"axes": {}}),
        (OTHER_ROBOT, [0, 1], "", {"axes": recorded_axes(invert_direction=True)}),
        # It holds more than its plan.
        (RECORD_DAMAGED, [0, 30], "", {}),
        (RECORD_DAMAGED, [0], '{"zeros": [{}]}', {}),
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


# What is waited for.


def waits_for(bench, *shown):
    """Whether the status says that it waits, and what for: shown are the names and the point."""
    message = bench.board.status.full_message
    return reports(message, TAKES_LONG) and all(one in str(message) for one in shown)


@pytest.mark.parametrize(
    "part, call, index, shown",
    [
        ("analyzer", "sweep", 3, ("the VNA: sweep", "point 3,")),
        ("analyzer", "confirm", 3, ("the VNA: settings", "point 3,")),
        ("analyzer", "connect", 0, ("the VNA: connection,",)),
        ("height", "height_m", 4, ("the height sensor: height", "point 3,")),
    ],
)
def test_a_call_that_takes_long_is_shown_until_it_ends(bench, part, call, index, shown):
    """One real second is a thousand for the survey."""
    hang, calls = threading.Event(), []
    device = getattr(bench, part)
    usual = getattr(device, call)

    def hang_once(*arguments):
        calls.append(arguments)
        if len(calls) == index + 1:
            hang.wait(LIMIT_S)
        return usual(*arguments)

    setattr(device, call, hang_once)
    bench.start()
    bench.wait_until(lambda: waits_for(bench, *shown))
    assert bench.board.status.state is (State.CHECKING if index == 0 else State.SURVEYING)
    hang.set()
    bench.complete()
    assert not waits_for(bench)
