"""Moves, homings and positions: nothing is measured where the antennas are not."""

import threading

import pytest
from fake_robot import LIMIT_S, ManualClock, reports

from gpr20_common.faults import PART_LOST, PART_SILENT
from gpr20_common.message import Fault, Message, Severity
from gpr20_main_control.errors import BLOCKED, MOVED_BY_OTHERS, DeviceError
from gpr20_main_control.mid.devices.robot import AxisReading, motion_error
from gpr20_survey.axes import UNKNOWN_ZERO
from gpr20_survey.faults import AXIS_MAY_MOVE
from gpr20_survey.plan.survey_state import SurveyState as State

STOPPED_BY_OTHERS = Message("stopped").with_fault(
    Fault("robot.asked_for", Message("Nothing to do"), Severity.NOTE)
)


def answers_first(axis, reading):
    usual, readings = axis.reading, [reading] * 3
    axis.reading = lambda: readings.pop() if readings else usual()


def test_what_an_axis_said_before_its_node_was_restarted_does_not_count(bench):
    answers_first(bench.x, AxisReading(0.0, True, False, 1.0, UNKNOWN_ZERO))
    # An axis whose node is still starting is waited for; one that is homed is not homed again.
    answers_first(bench.z, AxisReading(0.0, False, False, 100.0, UNKNOWN_ZERO))
    bench.y.homed = True
    bench.start()
    bench.complete()
    assert [axis.homings for axis in bench.axes] == [1, 0, 1]


def is_refused(axis):
    axis.fail_move = "the endstop was pressed"


def rests_at(coordinate):
    def set_up(axis):
        axis.failure = None
        axis.begin_move = lambda _target: setattr(axis, "coordinate", coordinate)

    return set_up


def never_ends(axis):
    axis.blocked.clear()


def falls_silent(axis):
    axis.blocked.clear()
    axis.begin_move = lambda _target: setattr(axis, "silent", True)


def is_stopped_by_another_client(axis):
    failure = motion_error(STOPPED_BY_OTHERS)
    axis.begin_move = lambda _target: setattr(axis, "failure", failure)


@pytest.mark.parametrize(
    "move, fault, shown, may_move",
    [
        (is_refused, BLOCKED, ("x", 10.0, "the endstop was pressed"), False),
        (rests_at(0.0), BLOCKED, ("x", 0.0, 10.0), False),
        (rests_at(10.01), BLOCKED, ("x", 10.01, 10.0), False),
        (never_ends, AXIS_MAY_MOVE, ("x", 10.0), True),
        (falls_silent, PART_LOST, ("x",), True),
        (is_stopped_by_another_client, BLOCKED, ("x", 10.0), False),
    ],
)
def test_a_move_that_does_not_arrive_pauses_the_survey_and_nothing_is_measured(
    bench, move, fault, shown, may_move
):
    move(bench.x)
    bench.start()
    message = bench.wait_for(State.PAUSED).message
    assert reports(message, fault, *shown) and message.may_move is may_move
    assert bench.analyzer.sweeps == 0 and bench.storage.samples == []
    assert not may_move or bench.x.stops


def test_vibrations_die_down_between_the_end_of_each_move_and_the_sweep(settling):
    waits, waited = settling.clock.waits_s, []
    for axis in settling.axes:
        begin = axis.begin_move
        axis.begin_move = lambda target, begin=begin: (waits.clear(), begin(target))
    settling.analyzer.on_sweep = lambda: waited.append(0.7 in waits)
    settling.start()
    settling.complete()
    assert waited == [True] * 24


def test_a_lost_result_is_settled_by_the_axis_own_coordinate(settling):
    settling.x.move_ended = lambda: False
    settling.start()
    settling.complete()


def test_a_move_that_fails_ends_the_others_before_anything_is_waited_for(bench):
    stopped = threading.Event()
    bench.analyzer.on_confirm = lambda _number: bench.go_on.wait(LIMIT_S) and ()
    bench.at_sweep(0, lambda: is_refused(bench.z))
    bench.y.stop = stopped.set
    bench.start()
    assert stopped.wait(LIMIT_S)
    assert bench.board.status.state is State.SURVEYING
    bench.go_on.set()
    bench.wait_for(State.PAUSED)


def fail_homing(message):
    def home(_limit_s):
        raise DeviceError(message)

    return home


@pytest.mark.parametrize("reason", [Message("it is stuck open"), STOPPED_BY_OTHERS])
def test_every_axis_is_homed_even_if_one_fails_and_the_failure_pauses_the_survey(bench, reason):
    bench.x.home = fail_homing(reason)
    bench.start()
    message = bench.wait_for(State.PAUSED).message
    assert BLOCKED in message.faults and reason in message.nested()
    assert [axis.homings for axis in bench.axes] == [0, 1, 1]


def test_a_trace_is_not_stored_if_the_axes_moved_during_its_sweep(bench):
    bench.at_sweep(0, lambda: setattr(bench.x, "coordinate", 10.01))
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, MOVED_BY_OTHERS, 0)
    assert bench.storage.samples == []


def test_an_axis_that_never_speaks_fails_the_survey_before_anything_moves(bench):
    bench.z.silent = True
    bench.start()
    message = bench.wait_for(State.FAILED).message
    assert reports(message, PART_SILENT, "z") and not message.may_move
    assert bench.x.moves == []


@pytest.fixture
def settling(make_bench):
    return make_bench(clock=ManualClock(), settle_s=0.7)
