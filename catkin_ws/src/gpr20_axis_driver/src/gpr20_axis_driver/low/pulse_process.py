"""A separate process for the pulses, which must be punctual.

The parent sends it the axis's hardware (pickled, opened here) and then one motion at a time.
It ends, with the pins low, when the parent closes the connection or dies; a parent that hangs
ends the motion.
It is started as a new interpreter: a fork of a process that runs ROS's threads would not work.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from multiprocessing.connection import Connection, Pipe
from typing import Callable, NoReturn, Optional

from gpr20_axis_driver import faults
from gpr20_axis_driver.axis_exceptions import PulseProcessError
from gpr20_axis_driver.low.scheduling import ORDINARY, Scheduling, realtime_scheduling
from gpr20_axis_driver.low.step_counter import StepCounter
from gpr20_axis_driver.motion import AxisHardware, Motion, MotionReport
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import OVERLOADED
from gpr20_common.message import Message

START_LIMIT_S = 20.0
END_LIMIT_S = 2.0
POLL_S = 0.005
# The parent counts a beat with every poll; one that counts none for this long can no longer
# stop the motion.
SILENT_PARENT_S = 2.0
# How often the endstop of an axis at rest is read [s].
ENDSTOP_PERIOD_S = 0.1
PARENT_GONE = (EOFError, BrokenPipeError, ConnectionResetError)


class PulseProcess:
    """The process as its parent sees it."""

    def __init__(
        self, hardware: AxisHardware, counter: StepCounter, ended: Callable[[Message], None]
    ) -> None:
        """Start it and wait until it is ready.

        Args:
            hardware: Opened in the process.
            counter: Where the steps are counted; shared.
            ended: Called from another thread, with the reason, if it ends unexpectedly.

        Raises:
            PulseProcessError: It cannot be started, or the hardware cannot be opened.
        """
        self._counter = counter
        self._ended = ended
        self._closing = False
        self._gone = threading.Event()
        self._connection, theirs = Pipe()
        with theirs:
            self._process = self._spawn(theirs.fileno())
        try:
            self._connection.send(hardware)
            self._scheduling = self._wait_ready()
        except BaseException:
            self._closing = True
            self._process.kill()
            self._process.wait()
            self._connection.close()
            raise
        self._waiter = threading.Thread(target=self._wait_for_end, daemon=True)
        self._waiter.start()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    @property
    def scheduling(self) -> Scheduling:
        """How the system schedules it."""
        return self._scheduling

    def run(self, motion: Motion, poll: Callable[[], None]) -> MotionReport:
        """Let the process carry out a motion and return its report.

        Args:
            motion: The motion; it is pickled.
            poll: Called every few milliseconds meanwhile; an exception in it ends the process.

        Raises:
            PulseProcessError: The process ended or failed.
        """
        self._counter.stop_requested = False
        try:
            poll()
            self._connection.send(motion)
            while not self._connection.poll(POLL_S):
                poll()
                self._counter.beat()
            answer = self._connection.recv()
        except PulseProcessError:
            self.kill()
            raise
        except (EOFError, OSError) as error:
            self._gone.wait(END_LIMIT_S)
            raise PulseProcessError(self._death()) from error
        except BaseException:
            self.kill()
            raise
        if isinstance(answer, PulseProcessError):
            self._gone.wait(END_LIMIT_S)
            raise answer
        return answer

    def kill(self) -> None:
        """End it at once; `ended` is called as for an unexpected end."""
        self._process.kill()
        self._gone.wait(END_LIMIT_S)

    def close(self) -> None:
        """End it: it stops its motion, leaves the pins low and is gone on return."""
        self._closing = True
        self._connection.close()
        if not self._gone.wait(END_LIMIT_S):
            # Killed, it cannot leave the pins low: `ended` must.
            self._closing = False
            self.kill()

    def _spawn(self, descriptor: int) -> subprocess.Popen:
        inherited = (descriptor, self._counter.descriptor)
        arguments = [*map(str, inherited), str(os.getpid())]
        return subprocess.Popen(
            [sys.executable, "-m", __name__, *arguments],
            pass_fds=inherited,
            stdin=subprocess.DEVNULL,
            # A separate session: a signal to the node's group must not end it in mid-pulse.
            start_new_session=True,
        )

    def _wait_ready(self) -> Scheduling:
        if not self._connection.poll(START_LIMIT_S):
            raise PulseProcessError(
                Message(
                    "the pulse process of this axis was not ready within {limit_s:g} s; reduce "
                    "this computer's load and restart the axis driver",
                    limit_s=START_LIMIT_S,
                ),
                fault=OVERLOADED,
            )
        try:
            answer = self._connection.recv()
        except EOFError:
            self._process.wait()
            raise PulseProcessError(self._death()) from None
        if isinstance(answer, PulseProcessError):
            raise answer
        return answer

    def _wait_for_end(self) -> None:
        self._process.wait()
        try:
            if not self._closing:
                self._ended(self._death())
        finally:
            self._gone.set()

    def _death(self) -> Message:
        status: Optional[int] = self._process.poll()
        if status is not None and status < 0:
            how = f"ended by {signal.Signals(-status).name}"
        else:
            how = f"exit status {status}"
        return Message(
            "the pulse process of this axis ended unexpectedly; see the log and home the axis",
            details=how,
        ).with_fault(faults.FAILED)


def serve(connection: Connection, counter: StepCounter, parent: int) -> None:
    """Carry out the parent's motions until it closes the connection or dies."""
    hardware: AxisHardware = connection.recv()
    scheduling = realtime_scheduling() if hardware.realtime else ORDINARY
    runner = hardware.open(counter)
    try:
        connection.send(scheduling)
        # Without an endstop there is nothing to read, and the process sleeps until a motion comes.
        period_s = None if hardware.parameters.sensor_pin is None else ENDSTOP_PERIOD_S
        while True:
            runner.read_endstop()
            while not connection.poll(period_s):
                runner.read_endstop()
            motion = connection.recv()
            connection.send(runner.run(motion, _Parent(counter, parent).wants_stop))
    finally:
        runner.close()


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


def main() -> NoReturn:
    """Run as the child; the arguments are two descriptors and the parent's number."""
    # From here on a termination runs every `finally`, so the pins end low.
    signal.signal(signal.SIGTERM, lambda _signal, _frame: sys.exit(128 + signal.SIGTERM))
    connection = Connection(int(sys.argv[1]))
    counter = StepCounter(int(sys.argv[2]))
    try:
        _serve_and_report(connection, counter, int(sys.argv[3]))
    except PARENT_GONE:
        # The parent has closed the connection or is dead; nobody is left to report to.
        sys.exit(0)
    raise AssertionError("serve() ends only by an exception")


def _serve_and_report(connection: Connection, counter: StepCounter, parent: int) -> None:
    try:
        serve(connection, counter, parent)
    except PARENT_GONE:
        raise
    except Gpr20Error as error:
        connection.send(PulseProcessError(error.message))
        sys.exit(1)
    except Exception as error:
        failure = Message(
            "the pulse process of this axis failed; see the log and home the axis",
            details=f"{type(error).__name__}: {error}",
        )
        connection.send(PulseProcessError(failure, fault=faults.FAILED))
        raise


if __name__ == "__main__":
    main()
