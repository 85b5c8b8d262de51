"""Pulses made by a process of their own: exact counts, stops, and every way of dying."""

import contextlib
import doctest
import os
import queue
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from fault_kit import raises_fault
from run_seed import SEED, draws
from simulated_axis import LIMIT_S, SimulatedAxis, exists, simulated_hardware, wait_until

from gpr20_axis_driver import faults
from gpr20_axis_driver.axis_exceptions import (
    AxisException,
    MotionStopped,
    NotHomedError,
    PulseProcessError,
    ZeroUnknownError,
)
from gpr20_axis_driver.low import pulse_process
from gpr20_axis_driver.mid import pulse_client
from gpr20_axis_driver.motion import never
from gpr20_common.faults import CONFIGURATION, MAY_MOVE, OVERLOADED
from gpr20_common.message import Message
from gpr20_simulator.low.shared_state import EndstopFault, open_shared_state
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import ZERO_UNKNOWN

README = Path(__file__).parents[2] / "README.md"


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
from gpr20_axis_driver.low.scheduling import realtime_scheduling
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
if os.getuid() == 0: os.setuid(65534)
print(realtime_scheduling())
"""


def test_pulses_are_punctual_or_say_why_not(make):
    pulses = make(AxisId.Z).pulses
    assert ("refused: " if pulses.unpunctual else "SCHED_FIFO") in str(pulses.scheduling)
    faster = make(AxisId.X, time_scale=10.0).pulses
    assert "ordinary scheduling" in str(faster.scheduling) and not faster.unpunctual
    said = subprocess.check_output([sys.executable, "-c", WITHOUT_RIGHTS], text=True)
    assert "realtime=False" in said and "SCHED_FIFO (Operation not permitted)" in said


class Move:
    """A move in the background."""

    def __init__(self, axis, target, stop=never):
        self._error = queue.SimpleQueue()
        threading.Thread(target=self._run, args=(axis.driver, target, stop)).start()

    def _run(self, driver, target, stop):
        try:
            driver.move_to_coordinate(target, stop)
        except AxisException as error:
            self._error.put(error)

    def error(self):
        """Return what the move has raised."""
        return self._error.get(timeout=LIMIT_S)


def test_moves_and_stops_at_random_never_lose_a_step(make):
    axis = make(AxisId.X, time_scale=500.0)
    axis.driver.homing(never)
    chance = random.Random(SEED)
    for _ in range(draws(25)):
        countdown = iter([False] * chance.randrange(1, 12))
        with contextlib.suppress(MotionStopped):
            axis.driver.move_to_coordinate(
                chance.randrange(0, 3000) / 100, lambda c=countdown: next(c, True)
            )
        assert round(axis.driver.current_coord * 100) == axis.true_steps


@pytest.fixture
def placed(make):
    """An axis that knows where it is without a homing, which takes long."""
    axis = make(AxisId.X)
    axis.pulses.place(200)
    axis.driver._homing_done = True
    return axis


def test_a_stop_ends_a_move_long_before_its_target(placed):
    requested = threading.Event()
    move = Move(placed, 600.0, requested.is_set)
    wait_until(lambda: placed.true_steps > 250)
    requested.set()
    assert isinstance(move.error(), MotionStopped)
    # It would take three minutes.
    assert placed.true_steps == placed.pulses.steps < 30_000
    assert placed.driver.homing_done
    # One that was stopped before it began makes no pulse.
    steps = placed.true_steps
    with pytest.raises(MotionStopped):
        placed.driver.move_to_coordinate(600.0, lambda: True)
    assert placed.true_steps == steps


def test_a_node_that_hangs_ends_its_move_and_keeps_an_exact_coordinate(placed):
    hung, go_on = threading.Event(), threading.Event()

    def hang():
        if placed.true_steps > 250:
            hung.set()
            go_on.wait(LIMIT_S)
        return False

    move = Move(placed, 600.0, hang)
    assert hung.wait(LIMIT_S)
    wait_until(lambda: time.monotonic_ns() - placed.world.last_pulse_ns(AxisId.X) > 5e8)
    go_on.set()
    assert move.error().message.fault_code == OVERLOADED.code
    assert placed.true_steps == placed.pulses.steps < 30_000
    assert placed.driver.homing_done


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_when_the_pulse_process_dies_in_a_move_the_pins_are_low_and_the_axis_is_not_homed(
    make, number
):
    axis = make(AxisId.X, time_scale=10.0)
    axis.driver.homing(never)
    before = axis.pulses.process_id
    move = Move(axis, 100.0)
    wait_until(lambda: axis.true_steps > 100)
    os.kill(before, number)
    error = move.error()
    assert isinstance(error, PulseProcessError)
    assert error.message.fault_code == faults.FAILED.code
    assert axis.pins_low and not exists(before)
    assert not axis.driver.homing_done and not axis.pulses.trusted
    axis.driver.homing(never)
    assert (axis.driver.current_coord, axis.true_steps) == (0.0, 0)
    assert axis.pulses.process_id != before


def test_when_the_pins_of_a_dead_process_cannot_be_set_low_the_axis_may_move(make, monkeypatch):
    axis = make(AxisId.Z)

    def refuse(*_arguments):
        raise AxisException(Message("no pins"), fault=CONFIGURATION)

    monkeypatch.setattr(type(axis.pulses._hardware), "open", refuse)
    os.kill(axis.pulses.process_id, signal.SIGKILL)
    wait_until(lambda: axis.pulses.failure and "no pins" in str(axis.pulses.failure))
    assert axis.pulses.failure.fault_code == MAY_MOVE.code
    assert axis.pulses.failure.may_move


def test_when_the_node_is_killed_in_a_turn_the_angle_is_still_known(make, tmp_path):
    node = subprocess.Popen(
        [sys.executable, str(Path(__file__).with_name("dying_node.py")), str(tmp_path)],
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


def test_when_node_and_pulse_process_are_killed_in_a_turn_homing_is_refused(make):
    axis = make(AxisId.Z)
    axis.driver.homing(never)
    move = Move(axis, 90.0)
    wait_until(lambda: axis.true_steps > 10)
    os.kill(axis.pulses.process_id, signal.SIGKILL)
    assert isinstance(move.error(), PulseProcessError)
    with raises_fault(ZERO_UNKNOWN, "set_zero", error=ZeroUnknownError):
        axis.driver.homing(never)
    axis.driver.set_zero()
    assert axis.driver.homing_done


def test_a_process_that_is_halted_in_a_move_ends_it_and_the_position_is_not_trusted(make):
    axis = make(AxisId.Z)
    axis.driver.homing(never)
    move = Move(axis, 90.0)
    wait_until(lambda: axis.true_steps > 15)
    os.kill(axis.pulses.process_id, signal.SIGSTOP)
    halted = axis.true_steps
    # A pause that its own process sees as a late pulse.
    time.sleep(0.2)
    os.kill(axis.pulses.process_id, signal.SIGCONT)
    error = move.error()
    assert isinstance(error, NotHomedError)
    assert error.message.fault_code == ZERO_UNKNOWN.code
    assert axis.true_steps - halted <= 1
    assert not axis.driver.homing_done


def test_a_process_that_hangs_is_ended_and_the_move_with_it(make, monkeypatch):
    monkeypatch.setattr(pulse_client, "STALL_LIMIT_S", 0.2)
    monkeypatch.setattr(pulse_client, "STALL_STEPS", 1)
    axis = make(AxisId.Z)
    axis.driver.homing(never)
    move = Move(axis, 90.0)
    wait_until(lambda: axis.true_steps > 5)
    process_id = axis.pulses.process_id
    os.kill(process_id, signal.SIGSTOP)
    error = move.error()
    assert isinstance(error, PulseProcessError)
    assert error.message.fault_code == faults.PULSE_LATE.code
    assert not exists(process_id)
    assert axis.pins_low


@pytest.mark.parametrize("hangs", [False, True])
def test_closing_ends_even_a_process_that_hangs_and_leaves_the_pins_low(make, monkeypatch, hangs):
    monkeypatch.setattr(pulse_process, "END_LIMIT_S", 0.2)
    axis = make(AxisId.Z)
    axis.driver.homing(never)
    process_id = axis.pulses.process_id
    move = Move(axis, 90.0)
    wait_until(lambda: axis.true_steps > 5)
    if hangs:
        os.kill(process_id, signal.SIGSTOP)
    axis.driver.close(timeout_s=0.05)
    wait_until(lambda: not exists(process_id))
    assert axis.pins_low
    assert isinstance(move.error(), PulseProcessError)


def test_the_endstop_is_read_all_the_time_and_each_touch_of_a_homing_is_counted(make):
    axis = make(AxisId.X, 50.0)
    wait_until(lambda: axis.pulses.endstop_pressed is False)
    axis.driver.homing()
    assert (axis.driver.endstop_pressed, axis.driver.endstop_presses) == (False, 2)
    axis.world.set_endstop_fault(AxisId.X, EndstopFault.STUCK_CLOSED)
    wait_until(lambda: axis.pulses.endstop_pressed)
    axis.world.set_endstop_fault(AxisId.X, EndstopFault.NONE)
    wait_until(lambda: axis.pulses.endstop_pressed is False)
    os.kill(axis.pulses.process_id, signal.SIGKILL)
    wait_until(lambda: axis.pulses.endstop_pressed is None)


def test_the_examples_of_the_readme_do_what_they_say(tmp_path):
    hardware = simulated_hardware(tmp_path, AxisId.X, time_scale=100.0)
    result = doctest.testfile(
        str(README), module_relative=False, globs={"hardware": hardware}, encoding="utf-8"
    )
    assert result.attempted > 0 and result.failed == 0
