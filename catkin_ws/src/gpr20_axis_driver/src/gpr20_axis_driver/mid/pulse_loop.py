"""The process that makes the pulses of an axis one by one, on pins, each edge at its time.

The node of the axis starts it and sends motions to it. It gets the axis's hardware (pickled, opened
here) and then one motion at a time. It ends, with the pins low, when its parent closes the
connection or dies; a parent that hangs ends the motion.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import math
import os
import signal
import sys
import time
from array import array
from multiprocessing.connection import Connection
from typing import List, NoReturn, Optional, Tuple

from gpr20_axis_driver.faults import PulseProcessError
from gpr20_axis_driver.low.pins import (
    EndstopInterface,
    Pins,
    StepperInterface,
    enable_motor_driver,
)
from gpr20_axis_driver.low.step_counter import StepCounter
from gpr20_axis_driver.motion import (
    AxisHardware,
    Ending,
    Lateness,
    Motion,
    MotionReport,
    StopRequested,
    Until,
)
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_SET_UP
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.axes import PULSE_PRIORITY, AxisParameters, Level, Pull, Ramp

# The parent counts a beat with every poll; one that counts none for this long can no longer
# stop the motion.
SILENT_PARENT_S = 2.0
# How often the endstop of an axis at rest is read [s].
ENDSTOP_PERIOD_S = 0.1
PARENT_GONE = (EOFError, BrokenPipeError, ConnectionResetError)
# From <sys/mman.h> and <sys/prctl.h> of Linux.
MCL_CURRENT, MCL_FUTURE = 1, 2
PR_SET_TIMERSLACK = 29
ORDINARY = Message("ordinary scheduling: the simulated robot does not run in real time")


class EdgeSchedule:
    """Absolute times of a motion's edges, corrected by when each was really made.

    A delay up to the limit is absorbed: the next edges keep their times, so a pause can be
    shorter than its due length by up to that limit, never by more. Beyond the limit all later
    edges are shifted, and the motion continues at the speed that the gap means: no burst follows.
    """

    def __init__(self, ramp: Ramp, late_limit_s: float, gap_limit_s: float, start_s: float) -> None:
        """Begin with the slowest pause.

        Args:
            ramp: Pauses of the steps.
            late_limit_s: Up to here later pulses make up for a delay; beyond it they slow down.
            gap_limit_s: Beyond it a motor above its slowest speed can lose steps.
            start_s: When the first edge is due [s of the clock].
        """
        self.due_s = start_s
        self.pause_s = ramp.max_pause_s
        self.lateness_s = array("d")
        self.slowed = 0
        self.gap_s = 0.0
        self._ramp = ramp
        self._late_limit_s, self._gap_limit_s = late_limit_s, gap_limit_s
        self._height = 0
        self._excess_s = 0.0

    def rise(self, now_s: float, steps_left: int) -> None:
        """Record a rising edge; `due_s` becomes the time of its falling edge.

        Args:
            now_s: When it is made [s of the clock].
            steps_left: How many steps are left, including this one.
        """
        late_s = now_s - self.due_s
        self.lateness_s.append(late_s)
        if late_s > self._late_limit_s:
            self._shift(late_s)
        self._excess_s = 0.0
        self.pause_s = self._ramp.pause_s(min(self._height, steps_left - 1))
        self._height += 1
        self.due_s += self.pause_s

    def fall(self, now_s: float) -> None:
        """Record a falling edge; `due_s` becomes the time of the next rising edge."""
        late_s = now_s - self.due_s
        if late_s > self._late_limit_s:
            self._shift(late_s)
        self.due_s += self.pause_s

    def too_late(self, now_s: float) -> bool:
        """Return whether the motor can have lost steps while it waited for this edge."""
        # At the slowest speed the motor may stop and start on any step.
        if self.pause_s >= self._ramp.max_pause_s:
            return False
        gap_s = self._excess_s + now_s - self.due_s
        if gap_s <= self._gap_limit_s:
            return False
        self.gap_s = gap_s
        return True

    def _shift(self, late_s: float) -> None:
        self.slowed += 1
        self.due_s += late_s
        self._excess_s += late_s
        # The step took two pauses and the delay: it was as slow as this.
        pause_s = self.pause_s + self._excess_s / 2.0
        self._height = min(self._height, self._ramp.height_after(pause_s))


class PulseLoop:
    """Steps a motor at absolute times."""

    def __init__(
        self,
        pins: Pins,
        parameters: AxisParameters,
        clock: Clock,
        counter: StepCounter,
        realtime: bool = True,
    ) -> None:
        """Set up the pins of the axis, step and direction low, and enable its motor driver.

        Args:
            pins: The pins.
            parameters: The axis.
            clock: The clock by which it moves.
            counter: Counts its steps.
            realtime: Whether late pulses are limited. Those of a simulated robot that is faster
                than the real one come as fast as they can be made, and say nothing of a motor.
        """
        self._stepper = StepperInterface(
            pins, parameters.dir_pin, parameters.step_pin, parameters.invert_direction
        )
        if parameters.enable_pin is not None:
            enable_motor_driver(pins, parameters.enable_pin, Level(parameters.enable_active))
        self._endstop: Optional[EndstopInterface] = None
        if parameters.sensor_pin is not None:
            self._endstop = EndstopInterface(
                pins,
                parameters.sensor_pin,
                Level(parameters.endstop_active),
                Pull(parameters.endstop_pull),
            )
        self._clock = clock
        self._late_limit_s = parameters.late_limit_s if realtime else math.inf
        self._gap_limit_s = parameters.gap_limit_s if realtime else math.inf
        self._counter = counter

    @classmethod
    def of(cls, hardware: AxisHardware, counter: StepCounter) -> PulseLoop:
        """Open the pins, step and direction low."""
        pins, realtime = hardware.open_pins(), hardware.realtime
        return cls(pins, hardware.parameters, hardware.clock, counter, realtime)

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest.

        A stop ramps down. The steps are counted at the edge on which the motor moves, so
        nothing that ends the motion loses one.
        """
        self._counter.begin()
        self._stepper.set_direction(motion.forward)
        start_s = self._clock.now_s()
        schedule = EdgeSchedule(motion.ramp, self._late_limit_s, self._gap_limit_s, start_s)
        ending, made = self._step_all(motion, schedule, stop_requested)
        if ending is not Ending.GAP:
            self._clock.sleep_until_s(schedule.due_s)
            self._counter.rest()
        return MotionReport(
            ending,
            made,
            self._pressed(),
            self._clock.now_s() - start_s,
            schedule.gap_s,
            Lateness.of(schedule.lateness_s, schedule.slowed),
        )

    def read_endstop(self) -> None:
        """Note whether the endstop is pressed now."""
        self._pressed()

    def close(self) -> None:
        """Leave the pins low and release them."""
        self._stepper.close()
        if self._endstop is not None:
            self._endstop.close()

    def _step_all(
        self, motion: Motion, schedule: EdgeSchedule, stop_requested: StopRequested
    ) -> Tuple[Ending, int]:
        change = 1 if motion.forward else -1
        last = motion.steps
        made = 0
        fallen_s = 0.0

        def hold() -> None:
            nonlocal made, fallen_s
            self._counter.count(change)
            made += 1
            self._clock.sleep_until_s(schedule.due_s)
            fallen_s = self._clock.now_s()

        while made < last:
            self._clock.sleep_until_s(schedule.due_s)
            early = self._early_ending(motion)
            if early is not None:
                return early, made
            if last == motion.steps and stop_requested():
                # Braking is a shorter motion: its ramp down begins now.
                braking = motion.ramp.braking_steps(schedule.pause_s) if made else 0
                last = min(last, made + braking)
                if made == last:
                    break
            now_s = self._clock.now_s()
            if schedule.too_late(now_s):
                return Ending.GAP, made
            schedule.rise(now_s, last - made)
            self._stepper.step(hold)
            if schedule.too_late(fallen_s):
                return Ending.GAP, made
            schedule.fall(fallen_s)
        return (Ending.COMPLETE if made == motion.steps else Ending.STOPPED), made

    def _early_ending(self, motion: Motion) -> Optional[Ending]:
        if motion.guarded and self._pressed():
            return Ending.PRESSED
        if motion.until is Until.NOTHING:
            return None
        if self._pressed() == (motion.until is Until.PRESSED):
            return Ending.UNTIL
        return None

    def _pressed(self) -> bool:
        if self._endstop is None:
            return False
        pressed = self._endstop.sample()
        self._counter.note_endstop(pressed)
        return pressed


def main() -> NoReturn:
    """Run as the process; the arguments are two descriptors and the parent's number."""
    # From here on a termination runs every `finally`, so the pins end low.
    signal.signal(signal.SIGTERM, lambda _signal, _frame: sys.exit(128 + signal.SIGTERM))
    connection = Connection(int(sys.argv[1]))
    try:
        _serve(connection, StepCounter(int(sys.argv[2])), int(sys.argv[3]))
    except PARENT_GONE:
        # The parent has closed the connection or is dead; nobody is left to report to.
        sys.exit(0)
    except Gpr20Error as error:
        with contextlib.suppress(*PARENT_GONE):  # its launch may end already
            connection.send(PulseProcessError(error.message))
        sys.exit(1)
    except Exception as error:
        failure = Message(
            "the pulse process of this axis failed; see the log and home the axis",
            details=f"{type(error).__name__}: {error}",
        )
        connection.send(PulseProcessError(failure))
        raise


def _serve(connection: Connection, counter: StepCounter, parent: int) -> NoReturn:
    """Carry out the parent's motions until it closes the connection or dies."""
    hardware: AxisHardware = connection.recv()
    scheduling = realtime_scheduling() if hardware.realtime else ORDINARY
    loop = PulseLoop.of(hardware, counter)
    try:
        connection.send(scheduling)
        # Without an endstop there is nothing to read, and the process sleeps until a motion comes.
        period_s = None if hardware.parameters.sensor_pin is None else ENDSTOP_PERIOD_S
        while True:
            loop.read_endstop()
            while not connection.poll(period_s):
                loop.read_endstop()
            motion = connection.recv()
            connection.send(loop.run(motion, _Parent(counter, parent).wants_stop))
    finally:
        loop.close()


class _Parent:
    """Decides, during one motion, whether to end it."""

    def __init__(self, counter: StepCounter, number: int) -> None:
        self._counter = counter
        self._number = number
        self._note()

    def _note(self) -> None:
        self._beats, self._noted_s = self._counter.beats, time.monotonic()

    def wants_stop(self) -> bool:
        """Return whether the parent requested the end, is dead, or hangs."""
        # A dead parent cannot set the flag; its child is then adopted by another process.
        if self._counter.stop_requested or os.getppid() != self._number:
            return True
        if self._counter.beats != self._beats:
            self._note()
        return time.monotonic() - self._noted_s > SILENT_PARENT_S


def realtime_scheduling() -> Message:
    """Request SCHED_FIFO, locked memory and exact timers for this process.

    Returns what was granted, or with a fault what was refused; the process works without it, less
    punctually.
    """
    # A garbage collection during a move would delay a pulse; there are no cycles to collect.
    gc.collect()
    gc.freeze()
    gc.disable()
    refused: List[str] = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PULSE_PRIORITY))
    except OSError as error:
        refused.append(f"SCHED_FIFO ({error.strerror})")
    library = ctypes.CDLL(None, use_errno=True)
    if library.mlockall(MCL_CURRENT | MCL_FUTURE) != 0:
        refused.append(f"locked memory ({os.strerror(ctypes.get_errno())})")
    # Has an effect only without SCHED_FIFO: ordinary timers may fire 50 us late by design.
    library.prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)
    if refused:
        return Message(
            "pulses are made without real-time scheduling and can be late; allow rtprio and "
            "memlock in /etc/security/limits.d",
            details=f"refused: {', '.join(refused)}",
        ).with_fault(NOT_SET_UP.as_warning())
    return Message("real-time scheduling", details=f"SCHED_FIFO {PULSE_PRIORITY}, memory locked")


if __name__ == "__main__":
    main()
