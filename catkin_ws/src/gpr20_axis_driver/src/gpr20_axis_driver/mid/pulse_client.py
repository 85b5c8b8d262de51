"""The pulses of an axis, made by a separate process."""

from __future__ import annotations

import threading
import time
from typing import Optional

from gpr20_axis_driver import faults
from gpr20_axis_driver.axis_exceptions import AxisException, NodeHungError, PulseProcessError
from gpr20_axis_driver.low.pulse_process import SILENT_PARENT_S, PulseProcess
from gpr20_axis_driver.low.step_counter import StepCounter, open_step_counter
from gpr20_axis_driver.motion import AxisHardware, Ending, Motion, MotionReport, StopRequested
from gpr20_common.faults import MAY_MOVE
from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import ZeroEpoch

# The pulse process of a previous node ramps down before it releases the axis.
LOCK_LIMIT_S = 5.0
# A process that makes no step for this long, and for the time of some steps, hangs.
STALL_LIMIT_S = 5.0
STALL_STEPS = 10
# When the zero of an axis was set that knows its position from the beginning: 2020-01-01.
MADE_US = 1_577_836_800_000_000


class PulseClient:
    """Starts the process, monitors it, and sets the pins low if it dies."""

    def __init__(self, hardware: AxisHardware) -> None:
        """Start the process; motions are possible on return.

        Raises:
            AxisException: The step count, the process or the hardware cannot be used.
        """
        self._hardware = hardware
        parameters = hardware.parameters
        new = not hardware.step_file.exists()
        self._counter = open_step_counter(hardware.step_file, parameters.step_size, LOCK_LIMIT_S)
        if new and hardware.first_steps is not None:
            self._counter.begin_zero(MADE_US)
            self._counter.place(hardware.first_steps)
        self._lock = threading.Lock()
        self._failure: Optional[Message] = None
        try:
            self._process = self._start()
        except BaseException:
            self._counter.close()
            raise

    @property
    def steps(self) -> int:
        """The step count."""
        return self._counter.steps

    @property
    def trusted(self) -> bool:
        """Whether the count is known to be the position of the motor."""
        return self._counter.trusted

    @property
    def failure(self) -> Optional[Message]:
        """Why no motion is possible now; None if one is."""
        with self._lock:
            return self._failure

    @property
    def endstop_pressed(self) -> Optional[bool]:
        """Whether the endstop is pressed, as read within the last tenth of a second.

        None if there is no endstop, or the process that reads it has ended.
        """
        return self._counter.endstop_pressed if self.failure is None else None

    @property
    def endstop_presses(self) -> int:
        """How many times the endstop has closed, as far as it was read."""
        return self._counter.endstop_presses

    @property
    def scheduling(self) -> Message:
        """How punctual the system lets the pulses be."""
        return self._process.scheduling.message

    @property
    def unpunctual(self) -> bool:
        """Whether real-time scheduling was asked for and refused."""
        return self._hardware.realtime and not self._process.scheduling.realtime

    @property
    def process_id(self) -> int:
        """Number of the pulse process."""
        return self._process.pid

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest.

        Raises:
            PulseProcessError: The process died or hung; the pins are low.
            NodeHungError: This node hung, so the process ended the motion; the count is exact.
        """
        watch = _Progress(self._counter, self._hardware)

        def poll() -> None:
            watch.check()
            if stop_requested():
                self._counter.stop_requested = True

        failure = self.failure
        if failure is not None:
            raise PulseProcessError(failure)
        report = self._process.run(motion, poll)
        if report.ending is Ending.STOPPED and not self._counter.stop_requested:
            raise NodeHungError(
                Message(
                    "the motion was ended because the axis driver did not respond for "
                    "{limit_s:g} s; reduce this computer's load",
                    limit_s=SILENT_PARENT_S,
                )
            )
        return report

    @property
    def zero(self) -> ZeroEpoch:
        """The zero that the count refers to."""
        return self._counter.zero

    def begin_zero(self, time_us: int) -> None:
        """Begin another epoch of the zero, found or set then [us since 1970]; `place` follows."""
        self._counter.begin_zero(time_us)

    def place(self, steps: int) -> None:
        """Set the position of the motor, which is at rest [motor steps]."""
        self._counter.place(steps)

    def distrust(self) -> None:
        """Note that the count is not the position of the motor, until it is placed again."""
        self._counter.begin()

    def revive(self) -> None:
        """Start the process again if it has died.

        Raises:
            PulseProcessError: It cannot be started.
        """
        if self.failure is not None:
            process = self._start()
            with self._lock:
                self._process = process
                self._failure = None

    def close(self) -> None:
        """End the process; the pins are low on return. Nothing else may be called afterwards."""
        self._process.close()

    def _start(self) -> PulseProcess:
        return PulseProcess(self._hardware, self._counter, self._on_death)

    def _on_death(self, reason: Message) -> None:
        with self._lock:
            self._failure = reason
        try:
            # Opening drives both pins low, wherever the dead process left them.
            self._hardware.open(self._counter).close()
        except AxisException as error:
            with self._lock:
                self._failure = Message(
                    "{reason}; its pins could not be set low: {pins_reason}; without the motors' "
                    "power, switch the robot off and on; then home the axis",
                    reason=reason,
                    pins_reason=error.message,
                ).reporting_only(MAY_MOVE)


class _Progress:
    """Detects a process that runs but makes no steps."""

    def __init__(self, counter: StepCounter, hardware: AxisHardware) -> None:
        self._counter = counter
        self._clock = hardware.clock
        # A scaled clock can pass any limit while this computer does something else.
        self._limit_s = STALL_LIMIT_S + 2.0 * STALL_STEPS * hardware.parameters.max_step
        self._note()

    def _note(self) -> None:
        self._steps = self._counter.steps
        self._real_s, self._clock_s = time.monotonic(), self._clock.now_s()

    def check(self) -> None:
        if self._counter.steps != self._steps:
            self._note()
            return
        real_s, clock_s = time.monotonic() - self._real_s, self._clock.now_s() - self._clock_s
        if min(real_s, clock_s) > self._limit_s:
            raise PulseProcessError(
                Message(
                    "the pulse process of this axis made no step for {time_s:.0f} s and was ended; "
                    "reduce this computer's load and home the axis",
                    time_s=real_s,
                ),
                fault=faults.PULSE_LATE,
            )
