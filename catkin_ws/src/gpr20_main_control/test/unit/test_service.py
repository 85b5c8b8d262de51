"""Maintenance: single axes are moved and the analyzer is tested, never beside a survey."""

import math
import threading
from types import SimpleNamespace

import pytest
from fake_robot import LIMIT_S, reports
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from survey_examples import AXES

from gpr20_common.faults import ASKED_FOR, IN_USE
from gpr20_common.message import Message
from gpr20_main_control.errors import (
    BLOCKED,
    STOPPED_BEFORE,
    DeviceError,
    RequestRefusedError,
    StopRequested,
)
from gpr20_main_control.mid.devices.robot import motion_error
from gpr20_main_control.mid.service import TEST_SWEEP, AxisAction, AxisMove, jog_target
from gpr20_main_control.mid.waits import Workers
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import NOT_HOMED, ZERO_UNKNOWN
from gpr20_survey.plan.survey_state import SurveyState as State

X, Y, Z = AxisId.X, AxisId.Y, AxisId.Z


def home(bench, axis):
    return bench.control.move_for_service(AxisMove(axis, AxisAction.HOME))


def jog(bench, axis, distance):
    return bench.control.move_for_service(AxisMove(axis, AxisAction.JOG, distance))


def in_background(call):
    """Return the future of a call that waits."""
    return Workers().begin(call)


def test_one_axis_is_homed_also_if_it_is_homed_already_and_the_analyzer_is_lost(bench):
    bench.nodes.note_silent("vna_acquisition")
    for homings in (1, 2):
        home(bench, Y)
        assert [axis.homings for axis in bench.axes] == [0, homings, 0]
    assert [str(one) for one in bench.activities] == ["homing the y axis", "None"] * 2


def test_a_jog_before_homing_is_refused(bench):
    refusals = ((X, NOT_HOMED), (Z, ZERO_UNKNOWN))
    for axis, fault in refusals:
        with raises_fault(fault, error=DeviceError):
            jog(bench, axis, 1.0)
    assert bench.x.moves == bench.z.moves == []


@settings(max_examples=draws(100))
@given(
    st.sampled_from(list(AXES.values())),
    st.floats(0, 1),
    st.sampled_from([-1, 1]),
    st.floats(-4, 4),
)
def test_no_jog_leaves_the_axis_or_goes_the_wrong_way(axis, place, sign, exponent):
    low, high = axis.distance_steps(axis.min_coord), axis.distance_steps(axis.max_coord)
    coordinate = axis.coordinate_of(round(low + place * (high - low)))
    distance = sign * 10**exponent
    target = jog_target(axis, coordinate, distance)
    assert axis.min_coord <= target <= axis.max_coord
    assert (target - coordinate) * distance >= 0.0
    assert abs(target - coordinate) <= max(abs(distance), axis.step_size) + axis.step_size / 2
    if axis.min_coord < coordinate < axis.max_coord and abs(distance) > axis.step_size:
        assert target != coordinate
    assert axis.coordinate_of(axis.distance_steps(target)) == target


def test_there_is_no_service_while_a_survey_has_not_ended(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    moves, connections = list(bench.x.moves), len(bench.analyzer.connections)
    for request in (
        lambda: jog(bench, X, 1.0),
        lambda: home(bench, X),
        lambda: bench.control.test_analyzer(""),
        lambda: bench.control.daily_check(0),
    ):
        with raises_fault(IN_USE, error=RequestRefusedError):
            request()
    assert bench.x.moves == moves
    assert len(bench.analyzer.connections) == connections
    assert bench.activities == []
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    home(bench, X)


def test_a_service_move_that_waits_for_another_request_when_stop_comes_does_not_begin(bench):
    lock, waiting = bench.control._requests, threading.Event()
    lock.acquire()
    bench.control._requests = SimpleNamespace(
        acquire=lambda **given: (waiting.set(), lock.acquire(**given))[1],
        release=lock.release,
        locked=lock.locked,
    )
    homing = in_background(lambda: home(bench, X))
    assert waiting.wait(LIMIT_S)
    bench.control.stop()
    lock.release()
    assert reports(homing.exception(LIMIT_S).message, STOPPED_BEFORE)
    assert not bench.x.homings


def test_a_homing_that_begins_while_a_stop_is_on_its_way_is_stopped_too(bench):
    order = []
    bench.y.stop = lambda: order.append("stop")
    bench.y.home = lambda _limit_s: (bench.control.stop(), order.append("home"))
    with raises_fault(ASKED_FOR, error=StopRequested):
        home(bench, Y)
    assert order == ["stop", "home", "stop"]


def test_a_stop_ends_a_homing(bench):
    bench.y.hanging.clear()
    begun, usual = threading.Event(), bench.y.home
    bench.y.home = lambda limit_s: (begun.set(), usual(limit_s))
    homing = in_background(lambda: home(bench, Y))
    assert begun.wait(LIMIT_S)
    bench.control.stop()
    assert reports(homing.exception(LIMIT_S).message, ASKED_FOR, "y")


def test_a_stop_stops_every_axis_while_the_request_is_held(bench):
    home(bench, X)
    held = threading.Event()
    bench.x.begin_move = lambda _target: (held.set(), bench.go_on.wait(LIMIT_S))
    jogging = in_background(lambda: jog(bench, X, 1.0))
    assert held.wait(LIMIT_S)
    bench.control.stop()
    assert [axis.stops for axis in bench.axes] == [1, 1, 1]
    bench.go_on.set()
    assert reports(jogging.exception(LIMIT_S).message, ASKED_FOR)


@pytest.mark.parametrize("stopped, fault", [("control", ASKED_FOR), ("x", None)])
def test_a_stop_ends_a_jog_beside_which_no_survey_starts(bench, stopped, fault):
    home(bench, X)
    begin_move = bench.x.begin_move

    def come_to_rest():
        bench.x.failure = motion_error(Message("stopped"))
        bench.x.blocked.set()

    bench.x.begin_move = lambda target: (bench.x.blocked.clear(), begin_move(target))
    bench.x.stop = come_to_rest
    jogging = in_background(lambda: jog(bench, X, 1.0))
    assert bench.x.begun.wait(LIMIT_S)
    with raises_fault(IN_USE, error=RequestRefusedError):
        bench.start()
    getattr(bench, stopped).stop()
    assert reports(jogging.exception(LIMIT_S).message, fault or BLOCKED)


def test_a_test_of_the_analyzer_says_what_its_sweep_shows(bench):
    found = bench.control.test_analyzer("")
    level_db = 20.0 * math.log10(math.hypot(1.0, bench.analyzer.level))
    assert (found.failure, found.points) == (None, TEST_SWEEP.points)
    assert (found.sweep_duration_s, found.level_db) == pytest.approx((5e-6, level_db))


@pytest.mark.parametrize("call", ["test_analyzer", "daily_check"])
def test_a_test_of_the_analyzer_beside_which_no_survey_starts_can_be_stopped(bench, call):
    may_sweep, sweeping = threading.Event(), threading.Event()
    bench.analyzer.on_sweep = lambda: (sweeping.set(), may_sweep.wait(LIMIT_S))
    results = []
    argument = {"test_analyzer": "", "daily_check": 0}[call]
    testing = in_background(lambda: results.append(getattr(bench.control, call)(argument)))
    assert sweeping.wait(LIMIT_S)
    with raises_fault(IN_USE, error=RequestRefusedError):
        bench.start()
    bench.control.stop()
    error = testing.exception(LIMIT_S)
    may_sweep.set()
    message = error.message if call == "daily_check" else results[0].failure
    assert message.fault_code == ASKED_FOR.code
