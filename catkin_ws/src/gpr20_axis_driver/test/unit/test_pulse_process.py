"""Pulses made by a process of their own: exact counts, stops, and every way of dying."""

import contextlib
import os
import random
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from axis_machine import LIMIT_S, SimulatedAxis
from fault_kit import raises_fault
from run_seed import SEED, draws
from wait_kit import wait_until

from gpr20_axis_driver import faults
from gpr20_axis_driver.faults import (
    AxisException,
    MotionStopped,
    NotHomedError,
    PulseProcessError,
)
from gpr20_axis_driver.mid import pulse_process
from gpr20_axis_driver.motion import never
from gpr20_common.faults import CONFIGURATION, MAY_MOVE, NOT_SET_UP, OVERLOADED
from gpr20_common.message import Message
from gpr20_simulator.low.shared_state import EndstopFault, open_shared_state
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import ZERO_UNKNOWN


@pytest.fixture
def make(tmp_path):
    """Make axes that are closed in the end, one at a time for each name."""
    with contextlib.ExitStack() as ending:

        def make_axis(axis, time_scale=1.0):
            made = SimulatedAxis(tmp_path, axis, time_scale)
            ending.callback(made.pulses.close)
            return made

        yield make_axis


WITHOUT_RIGHTS = """
import os, resource
from gpr20_axis_driver.mid.pulse_loop import realtime_scheduling
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
if os.getuid() == 0: os.setuid(65534)
said = realtime_scheduling()
print(said.fault_code, *said.all_details)
"""


def test_pulses_are_punctual_or_say_why_not(make):
    pulses = make(AxisId.Z).pulses
    said = pulses.scheduling
    assert said.fault_code in ("", NOT_SET_UP.as_warning().code) and "SCHED_FIFO" in repr(said)
    faster = make(AxisId.X, time_scale=10.0).pulses
    assert "ordinary scheduling" in str(faster.scheduling) and not faster.scheduling.fault_code
    said = subprocess.check_output([sys.executable, "-c", WITHOUT_RIGHTS], text=True)
    assert NOT_SET_UP.as_warning().code in said and "SCHED_FIFO (Operation not permitted)" in said


def begin(axis, target, stop=never):
    """Begin a move in the background."""
    return ThreadPoolExecutor(1).submit(axis.driver.move_to_coordinate, target, stop)


def exists(process_id):
    """Return whether there is such a process, a zombie included."""
    return Path(f"/proc/{process_id}").exists()


def test_moves_and_stops_at_random_never_lose_a_step(make):
    axis = make(AxisId.X, time_scale=500.0)
    axis.driver.homing(never)
    chance = random.Random(SEED)
    for _ in range(draws(75)):
        polls, target = iter([False] * chance.randrange(12)), chance.randrange(0, 3000) / 100
        with contextlib.suppress(MotionStopped):
            axis.driver.move_to_coordinate(target, lambda polls=polls: next(polls, True))
        assert round(axis.driver.current_coord * 100) == axis.true_steps


def test_a_node_that_hangs_ends_its_move_and_keeps_an_exact_coordinate(make):
    axis, hung, go_on = make(AxisId.X), threading.Event(), threading.Event()
    # It knows where it is without a homing, which takes long.
    axis.driver._begin_zero(200, 0)

    def hang():
        if axis.true_steps > 250:
            hung.set()
            go_on.wait(LIMIT_S)
        return False

    move = begin(axis, 600.0, hang)
    assert hung.wait(LIMIT_S)
    wait_until(lambda: time.monotonic_ns() - axis.world.last_pulse_ns(AxisId.X) > 2e9)
    go_on.set()
    assert move.exception(LIMIT_S).message.fault_code == OVERLOADED.code
    assert axis.true_steps == axis.pulses.steps < 30_000
    assert axis.driver.homing_done


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_when_the_pulse_process_dies_in_a_turn_the_pins_are_low_and_the_zero_must_be_set(
    make, number
):
    # So slowly that it is caught in the turn: of 6 s.
    axis = make(AxisId.Z, time_scale=0.2)
    axis.driver.homing(never)
    before = axis.pulses.process_id
    move = begin(axis, 90.0)
    wait_until(lambda: axis.true_steps > 10)
    os.kill(before, number)
    error = move.exception(LIMIT_S)
    assert isinstance(error, PulseProcessError)
    assert error.message.fault_code == faults.FAILED.code
    assert axis.pins_low and not exists(before)
    assert not axis.driver.homing_done and not axis.pulses.trusted
    with raises_fault(ZERO_UNKNOWN, "set_zero", error=NotHomedError):
        axis.driver.homing(never)
    axis.driver.set_zero()
    assert axis.driver.homing_done and axis.pulses.process_id != before


def test_when_the_pins_of_a_dead_process_cannot_be_set_low_the_axis_may_move(make, monkeypatch):
    axis = make(AxisId.Z)

    def refuse(*_arguments):
        raise AxisException(Message("no pins"), fault=CONFIGURATION)

    monkeypatch.setattr(type(axis.pulses._hardware), "open_pins", refuse)
    os.kill(axis.pulses.process_id, signal.SIGKILL)
    wait_until(lambda: axis.pulses.failure and "no pins" in str(axis.pulses.failure))
    assert axis.pulses.failure.fault_code == MAY_MOVE.code
    assert axis.pulses.failure.may_move


DYING_NODE = """
import sys, pathlib
from axis_machine import AxisId, SimulatedAxis
axis = SimulatedAxis(pathlib.Path(sys.argv[1]), AxisId.Z, time_scale=0.2)
axis.driver.homing()
print(axis.pulses.process_id, flush=True)
axis.driver.move_to_coordinate(90.0)
"""


def test_when_the_node_is_killed_in_a_turn_the_angle_is_still_known(make, tmp_path):
    node = subprocess.Popen(
        [sys.executable, "-c", DYING_NODE, str(tmp_path)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
    )
    process_id = int(node.stdout.readline())
    world = open_shared_state(tmp_path / "world")
    wait_until(lambda: world.steps(AxisId.Z) > 10)
    node.kill()
    node.communicate()
    wait_until(lambda: not exists(process_id))
    assert world.pins_low(AxisId.Z)
    assert 10 < world.steps(AxisId.Z) < 50
    axis = make(AxisId.Z)
    assert not axis.driver.homing_done
    axis.driver.homing(never)
    assert (axis.true_steps, axis.driver.current_coord) == (0, 0.0)


@pytest.fixture
def turning(make, monkeypatch):
    """An axis in a turn, and the turn; its limits are short."""
    monkeypatch.setattr(pulse_process, "STALL_LIMIT_S", 1.0)
    monkeypatch.setattr(pulse_process, "STALL_STEPS", 1)
    monkeypatch.setattr(pulse_process, "END_LIMIT_S", 0.2)
    axis = make(AxisId.Z, time_scale=0.2)
    axis.driver.homing(never)
    move = begin(axis, 90.0)
    wait_until(lambda: axis.true_steps > 5)
    return axis, move, axis.pulses.process_id


def test_a_process_that_hangs_is_ended_and_the_move_with_it(turning):
    axis, move, process_id = turning
    os.kill(process_id, signal.SIGSTOP)
    error = move.exception(LIMIT_S)
    assert isinstance(error, PulseProcessError)
    assert error.message.fault_code == faults.PULSE_LATE.code
    assert axis.pins_low and not exists(process_id)


@pytest.mark.parametrize("hangs", [False, True])
def test_closing_ends_even_a_process_that_hangs_and_leaves_the_pins_low(turning, hangs):
    axis, move, process_id = turning
    if hangs:
        os.kill(process_id, signal.SIGSTOP)
    axis.driver.close(timeout_s=0.05)
    wait_until(lambda: not exists(process_id))
    assert axis.pins_low
    assert isinstance(move.exception(LIMIT_S), PulseProcessError)


def test_the_endstop_is_read_all_the_time_and_each_touch_of_a_homing_is_counted(make):
    axis = make(AxisId.X, 50.0)
    wait_until(lambda: axis.pulses.endstop_pressed is False)
    axis.driver.homing()
    assert (axis.pulses.endstop_pressed, axis.pulses.endstop_presses) == (False, 2)
    axis.world.set_endstop_fault(AxisId.X, EndstopFault.STUCK_CLOSED)
    wait_until(lambda: axis.pulses.endstop_pressed)
    axis.world.set_endstop_fault(AxisId.X, EndstopFault.NONE)
    wait_until(lambda: axis.pulses.endstop_pressed is False)
    os.kill(axis.pulses.process_id, signal.SIGKILL)
    wait_until(lambda: axis.pulses.endstop_pressed is None)
