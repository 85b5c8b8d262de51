"""The pulses of an axis, made by a process of their own."""

from __future__ import annotations

import threading
import time

from gpr20_axis_driver.axis_exceptions import AxisException, NodeHungError, PulseProcessError
from gpr20_axis_driver.low.pulse_process import SILENT_PARENT_S, PulseProcess
from gpr20_axis_driver.low.step_counter import StepCounter, open_step_counter
from gpr20_axis_driver.motion import AxisHardware, Ending, Motion, MotionReport, StopRequested

# A former node's pulse process ramps down before it lets go of the axis.
LOCK_LIMIT_S = 5.0
# A process that makes no step for so long, and for some steps' time, is hung.
STALL_LIMIT_S = 5.0
STALL_STEPS = 10


class PulseClient:
    """Starts the process, watches it, and makes the pins safe if it dies."""

    def __init__(self, hardware: AxisHardware) -> None:
        """Begin; motions are possible on return.

        Raises:
            AxisException: The step count, the process or the hardware cannot be used.
        """
        self._hardware = hardware
        parameters = hardware.parameters
        new = not hardware.step_file.exists()
        self._counter = open_step_counter(hardware.step_file, parameters.step_size, LOCK_LIMIT_S)
        if new and hardware.first_steps is not None:
            self._counter.place(hardware.first_steps)
        self._lock = threading.Lock()
        self._failure = ""
        try:
            self._process = self._start()
        except BaseException:
            self._counter.close()
            raise

    @property
    def steps(self) -> int:
        """The count of the steps."""
        return self._counter.steps

    @property
    def trusted(self) -> bool:
        """Whether the count is known to be where the motor rests."""
        return self._counter.trusted

    @property
    def failure(self) -> str:
        """Why no motion is possible now; empty if one is."""
        with self._lock:
            return self._failure

    @property
    def scheduling(self) -> str:
        """How punctual the system lets the pulses be, as a sentence."""
        return self._process.scheduling.sentence

    @property
    def unpunctual(self) -> bool:
        """Whether real-time scheduling was asked for and refused."""
        return self._hardware.realtime and not self._process.scheduling.realtime

    @property
    def process_id(self) -> int:
        """Number of the process that makes the pulses."""
        return self._process.pid

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor rests.

        Raises:
            PulseProcessError: The process died or hung; the pins are low.
            NodeHungError: This node hung, so the process ended the motion; the count is exact.
        """
        watch = _Progress(self._counter, self._hardware)

        def poll() -> None:
            watch.check()
            if stop_requested():
                self._counter.stop_requested = True

        if self.failure:
            raise PulseProcessError(self.failure)
        report = self._process.run(motion, poll)
        if report.ending is Ending.STOPPED and not self._counter.stop_requested:
            raise NodeHungError(
                f"the motion was ended because the axis's node could not have stopped it for "
                f"{SILENT_PARENT_S:g} s: the node hung; look at what else this computer does"
            )
        return report

    def place(self, steps: int) -> None:
        """Set where the motor rests [motor steps]."""
        self._counter.place(steps)

    def revive(self) -> None:
        """Start the process again if it has died.

        Raises:
            PulseProcessError: It cannot be started.
        """
        if self.failure:
            process = self._start()
            with self._lock:
                self._process = process
                self._failure = ""

    def close(self) -> None:
        """End the process; the pins are low on return. Nothing else may be called after."""
        self._process.close()

    def _start(self) -> PulseProcess:
        return PulseProcess(self._hardware, self._counter, self._on_death)

    def _on_death(self, reason: str) -> None:
        with self._lock:
            self._failure = reason
        try:
            # Opening drives both pins low, wherever the dead process left them.
            self._hardware.open(self._counter).close()
        except AxisException as error:
            with self._lock:
                self._failure = f"{reason}; and its pins could not be made low: {error}"


class _Progress:
    """Notices a process that lives but makes no steps."""

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
                f"the process that makes the pulses made no step for {real_s:.0f} s and was ended; "
                "look at what else this computer does, and home the axis"
            )
