"""The pulses of an axis, made by a process of their own, which must be punctual."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from multiprocessing.connection import Connection, Pipe
from typing import Optional

from gpr20_axis_driver import faults
from gpr20_axis_driver.faults import AxisException, PulseProcessError
from gpr20_axis_driver.low.step_counter import StepCounter, open_step_counter
from gpr20_axis_driver.mid.pulse_loop import SILENT_PARENT_S, PulseLoop
from gpr20_axis_driver.motion import AxisHardware, Ending, Motion, MotionReport, StopRequested
from gpr20_common.faults import MAY_MOVE, OVERLOADED
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes import ZeroEpoch

# A new interpreter: a fork of a process with ROS's threads would not work.
SERVER = "gpr20_axis_driver.mid.pulse_loop"
START_LIMIT_S = 20.0
END_LIMIT_S = 2.0
POLL_S = 0.005
# The pulse process of a previous node ramps down before it releases the axis.
LOCK_LIMIT_S = 5.0
# A process that makes no step for this long, and for the time of some steps, hangs.
STALL_LIMIT_S = 5.0
STALL_STEPS = 10
# When the zero of an axis was set that knows its position from the beginning: 2020-01-01.
MADE_US = 1_577_836_800_000_000


class PulseProcess:
    """The process as the axis's node sees it; an `AxisMotions`.

    If it dies, the pins are set low and the axis must be homed, which starts it again.
    """

    def __init__(self, hardware: AxisHardware) -> None:
        """Start it; motions are possible on return.

        Raises:
            AxisException: The step count, the process or the hardware cannot be used.
        """
        self._hardware = hardware
        new = not hardware.step_file.exists()
        step_size = hardware.parameters.step_size
        self._counter = open_step_counter(hardware.step_file, step_size, LOCK_LIMIT_S)
        self.distrust = self._counter.begin
        if new and hardware.first_steps is not None:
            self.begin_zero(hardware.first_steps, MADE_US)
        self._failure: Optional[Message] = None
        self._closing = False
        try:
            self._start()
        except BaseException:
            self._counter.close()
            raise

    @property
    def hardware(self) -> Hardware:
        return self._hardware.description

    @property
    def steps(self) -> int:
        return self._counter.steps

    @property
    def trusted(self) -> bool:
        return self._counter.trusted

    @property
    def failure(self) -> Optional[Message]:
        return self._failure

    @property
    def endstop_pressed(self) -> Optional[bool]:
        return self._counter.endstop_pressed if self._failure is None else None

    @property
    def endstop_presses(self) -> int:
        return self._counter.endstop_presses

    @property
    def scheduling(self) -> Message:
        return self._scheduling

    @property
    def zero(self) -> ZeroEpoch:
        return self._counter.zero

    @property
    def process_id(self) -> int:
        return self._process.pid

    def begin_zero(self, steps: int, time_us: int) -> None:
        self._counter.begin_zero(time_us)
        self._counter.place(steps)

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest.

        Raises:
            PulseProcessError: The process died or hung; the pins are low.
            AxisException: This node hung, so the process ended the motion; the count is exact.
        """
        if self._failure is not None:
            raise PulseProcessError(self._failure)
        progress = _Progress(self._counter, self._hardware)
        gone = self._gone

        def poll() -> None:
            progress.check()
            if stop_requested():
                self._counter.stop_requested = True

        self._counter.stop_requested = False
        try:
            poll()
            self._connection.send(motion)
            while not self._connection.poll(POLL_S):
                poll()
                self._counter.beat()
            answer = self._connection.recv()
        except PulseProcessError:
            self._kill()
            raise
        except (EOFError, OSError) as error:
            gone.wait(END_LIMIT_S)
            raise PulseProcessError(_death(self._process)) from error
        except BaseException:
            self._kill()
            raise
        if isinstance(answer, PulseProcessError):
            gone.wait(END_LIMIT_S)
            raise answer
        report: MotionReport = answer
        if report.ending is Ending.STOPPED and not self._counter.stop_requested:
            raise AxisException(
                Message(
                    "the motion was ended because the axis driver did not respond for "
                    "{limit_s:g} s; reduce this computer's load",
                    limit_s=SILENT_PARENT_S,
                ),
                fault=OVERLOADED,
            )
        return report

    def revive(self) -> None:
        """Start it again if it has died; raises a PulseProcessError if it cannot be started."""
        if self._failure is not None:
            self._start()
            self._failure = None

    def close(self) -> None:
        """End it: it stops its motion, leaves the pins low and is gone on return."""
        self._closing = True
        self._connection.close()
        if not self._gone.wait(END_LIMIT_S):
            # Killed, it cannot leave the pins low: this process must.
            self._closing = False
            self._kill()

    def _kill(self) -> None:
        self._process.kill()
        self._gone.wait(END_LIMIT_S)

    def _start(self) -> None:
        connection, theirs = Pipe()
        with theirs:
            process = self._spawn(theirs.fileno())
        try:
            connection.send(self._hardware)
            scheduling = _answer_at_start(connection, process)
        except BaseException:
            process.kill()
            process.wait()
            connection.close()
            raise
        gone = threading.Event()
        self._connection, self._process, self._gone = connection, process, gone
        self._scheduling = scheduling
        threading.Thread(target=self._wait_for_end, args=(process, gone), daemon=True).start()

    def _spawn(self, descriptor: int) -> subprocess.Popen:
        inherited = (descriptor, self._counter.descriptor)
        arguments = [*map(str, inherited), str(os.getpid())]
        return subprocess.Popen(
            [sys.executable, "-m", SERVER, *arguments],
            pass_fds=inherited,
            stdin=subprocess.DEVNULL,
            # A separate session: a signal to the node's group must not end it in mid-pulse.
            start_new_session=True,
        )

    def _wait_for_end(self, process: subprocess.Popen, gone: threading.Event) -> None:
        process.wait()
        try:
            if not self._closing:
                self._set_pins_low(_death(process))
        finally:
            gone.set()

    def _set_pins_low(self, death: Message) -> None:
        self._failure = death
        try:
            # Opening drives both pins low, wherever the dead process left them.
            PulseLoop.of(self._hardware, self._counter).close()
        except AxisException as error:
            self._failure = Message(
                "{reason}; its pins could not be set low: {pins_reason}; without the motors' "
                "power, switch the robot off and on; then home the axis",
                reason=death,
                pins_reason=error.message,
            ).reporting_only(MAY_MOVE)


def _answer_at_start(connection: Connection, process: subprocess.Popen) -> Message:
    if not connection.poll(START_LIMIT_S):
        raise PulseProcessError(
            Message(
                "the pulse process of this axis was not ready within {limit_s:g} s; reduce "
                "this computer's load and restart the axis driver",
                limit_s=START_LIMIT_S,
            ),
            fault=OVERLOADED,
        )
    try:
        answer = connection.recv()
    except EOFError:
        process.wait()
        raise PulseProcessError(_death(process)) from None
    if isinstance(answer, PulseProcessError):
        raise answer
    scheduling: Message = answer
    return scheduling


def _death(process: subprocess.Popen) -> Message:
    status: Optional[int] = process.poll()
    if status is not None and status < 0:
        how = f"ended by {signal.Signals(-status).name}"
    else:
        how = f"exit status {status}"
    return Message(
        "the pulse process of this axis ended unexpectedly; see the log and home the axis",
        details=how,
    ).with_fault(faults.FAILED)


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
