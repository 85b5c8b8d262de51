"""Waits and calls of the main control: what ends them early, and what shows that they are late."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from concurrent.futures import Future
from concurrent.futures import wait as wait_for_futures
from typing import Any, Callable, Iterator, Optional, Tuple, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, ShutDownRequested, StopRequested
from gpr20_main_control.mid.devices.node_liveness import NodeLiveness
from gpr20_main_control.mid.survey.survey_status import SurveyStatus
from gpr20_survey.faults import STOPPED, TAKES_LONG

# Called repeatedly during a wait; an error that it raises ends the wait.
Check = Callable[[], None]
Result = TypeVar("Result")
# How often a wait looks for what ends it [s].
POLL_S = 0.05
# Axes that slow down from their top speed come to rest well within this time, and so much has the
# last sweep of a survey to be confirmed; otherwise it is measured again later [s].
REST_LIMIT_S = 10.0
# A wait is shown when it takes this much longer than expected [s].
LATE_S = 1.5
# Three axes, height, sweep and its confirmation at the same time, and as many that were given up.
MOST_WORKERS = 16
# While axes move, the thread that would stop them must have looked within this time [s].
ATTENTION_S = 1.0


class Interruption:
    """What ends a wait early: a stop request and, of a survey, a lost node.

    Attributes:
        stop: Set when what is in progress must end.
        clock: The clock of every wait.
    """

    def __init__(self, clock: Clock, nodes: Optional[NodeLiveness] = None) -> None:
        """Begin without a reason; `nodes` are those without which a survey cannot continue."""
        self.stop = threading.Event()
        self.clock = clock
        self._nodes = nodes
        self._shutting_down = self._moving = False
        self._looked_s = 0.0

    @contextlib.contextmanager
    def moving(self) -> Iterator[None]:
        """Be needed: while axes move, somebody must look for what ends their motion."""
        self._looked_s, self._moving = time.monotonic(), True
        try:
            yield
        finally:
            self._moving = False

    @property
    def is_neglected(self) -> bool:
        """Whether axes move, and nobody looks."""
        return self._moving and time.monotonic() - self._looked_s > ATTENTION_S

    def shut_down(self) -> None:
        """End every wait, because the main control ends."""
        self._shutting_down = True
        self.stop.set()

    def check(self) -> None:
        """Raise StopRequested after a stop, NodeLostError if a node is lost or was restarted."""
        self.check_stop()
        if self._nodes is not None:
            self._nodes.check()

    def check_stop(self) -> None:
        """Raise StopRequested after a stop, ShutDownRequested if the main control ends."""
        self._looked_s = time.monotonic()
        if self._shutting_down:
            raise ShutDownRequested(Message("the robot is shut down"), fault=STOPPED)
        if self.stop.is_set():
            raise StopRequested(Message("a stop was requested"))

    def wait_s(self, duration_s: float) -> None:
        """Wait [s], unless `check` raises."""
        self.clock.wait_s(self.stop, duration_s)
        self.check()

    def wait_until(self, condition: Callable[[], bool], limit_s: float) -> bool:
        """Wait for a condition, at most so long [s]; return whether it is true."""
        deadline_s = self.clock.now_s() + limit_s
        while not condition():
            if self.clock.now_s() > deadline_s:
                return False
            self.wait_s(POLL_S)
        return True

    def time_limit(self, limit_s: float, error: DeviceError, stops: bool = False) -> Check:
        """Return a check that ends a wait with an error after a time from now [s].

        With `stops` a stop ends it too.
        """
        deadline_s = self.clock.now_s() + limit_s

        def check() -> None:
            if stops:
                self.check_stop()
            if self.clock.now_s() > deadline_s:
                raise error

        return check


class WaitStatus:
    """Shows in the status which part of the robot takes longer than expected."""

    def __init__(self, status: SurveyStatus, interruption: Interruption) -> None:
        self._status, self._interruption = status, interruption

    @contextlib.contextmanager
    def shown(
        self,
        part: Message,
        action: Message,
        limit_s: float,
        expected_s: float = 0.0,
        check: Optional[Check] = None,
    ) -> Iterator[Check]:
        """Yield a check to call repeatedly during a wait.

        Args:
            part: The part of the robot that is waited for.
            action: What it does.
            limit_s: When the wait ends in any case [s].
            expected_s: How long it usually takes [s].
            check: An error that it raises ends the wait; None: an interruption does.
        """
        check_wait, clock = check or self._interruption.check, self._interruption.clock
        late_s = clock.now_s() + expected_s + LATE_S
        # For people: by the clock on the wall of the robot.
        until = time.strftime("%H:%M:%S", time.localtime(time.time() + limit_s))
        waiting: Optional[Message] = None

        def check_and_show() -> None:
            nonlocal waiting
            check_wait()
            if waiting is None and clock.now_s() > late_s:
                waiting = Message(
                    "Waiting for {part}: {action}, until {time} at the latest",
                    part=part,
                    action=action,
                    time=until,
                ).with_fault(TAKES_LONG)
                self._status.update(waiting=waiting)

        try:
            yield check_and_show
        finally:
            if waiting is not None:
                self._status.update(waiting=None)


class Workers:
    """Threads that are kept for the next calls.

    They are daemons, unlike those of concurrent.futures: a call that hangs in a device outlives the
    survey that gave it up, but not the node. Of one thread the next call waits for the end of a
    call that was given up, which would otherwise undo in its device what later calls requested.
    """

    def __init__(self, most: int = MOST_WORKERS) -> None:
        """Start no thread yet; more than `most` calls at the same time wait for each other."""
        self._most = most
        self._lock = threading.Lock()
        self._threads = 0
        self._calls: queue.SimpleQueue[Tuple[Future[Any], Callable[[], Any]]] = queue.SimpleQueue()

    def begin(self, call: Callable[[], Result]) -> Future[Result]:
        """Begin a call and return at once."""
        future: Future[Result] = Future()
        with self._lock:
            if self._threads < self._most:
                threading.Thread(target=self._work, name="worker", daemon=True).start()
                # Counted when it runs: the system may have refused it.
                self._threads += 1
            self._calls.put((future, call))
        return future

    def call(self, call: Callable[[], Result], check: Check) -> Result:
        """Make a call in its turn and return its result, as `result_of` does."""
        return result_of(self.begin(call), check)

    def _work(self) -> None:
        while True:
            future, call = self._calls.get()
            if future.set_running_or_notify_cancel():  # otherwise it was given up
                try:
                    future.set_result(call())
                except BaseException as error:  # raised again by `result_of`
                    future.set_exception(error)
            # They have the result, and the next call may be late.
            del future, call


def result_of(future: Future[Result], check: Check) -> Result:
    """Return the result of a call, or raise what it raised.

    Args:
        future: The call. If the wait for it is given up before it has begun, it is never made.
        check: Called repeatedly meanwhile; an error that it raises ends the wait.
    """
    try:
        while not wait_for_futures([future], POLL_S).done:
            check()
    finally:
        future.cancel()  # a call that has begun continues
    return future.result()
