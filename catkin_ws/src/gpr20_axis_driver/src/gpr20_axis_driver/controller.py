"""Another controller than the pins: what a class outside this repository implements, and its use.

Its methods are called by one thread at a time. One that does not return is an error of the whole
process, which ends (`overdue`): nothing else ends the call.
"""

from __future__ import annotations

import contextlib
import threading
import time
from dataclasses import dataclass
from typing import Callable, Iterator, Optional, Protocol

from gpr20_axis_driver.faults import ControllerError, EndstopError, MotionStopped, NotHomedError
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.homing import TRAVEL_MARGIN
from gpr20_axis_driver.motion import Ending, Motion, MotionReport, StopRequested
from gpr20_common.message import Message
from gpr20_common.mid.checks import load_extension
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes import HOMING_BACKOFFS, UNKNOWN_ZERO, AxisParameters, ZeroEpoch
from gpr20_survey.faults import AXIS_MAY_MOVE, NOT_HOMED

# The longest that any method of a controller may take [s].
CALL_LIMIT_S = 3.0
MOVING_PERIOD_S = 0.02
RESTING_PERIOD_S = 0.1
# A motion may take this many times its computed duration, and this much longer, as may a stop [s].
SLOWEST_FACTOR = 2.0
MARGIN_S = 10.0
FAILED = Message("the controller of this axis failed; see the log and home the axis").with_fault(
    AXIS_MAY_MOVE
)
LATE = Message(
    "the controller of this axis did not end a motion in time; check the motor and the endstop, "
    "and home the axis"
).with_fault(AXIS_MAY_MOVE)
SILENT = Message(
    "the controller of this axis did not answer for {limit_s:g} s; check its power and cable, and "
    "home the axis",
    limit_s=CALL_LIMIT_S,
).with_fault(AXIS_MAY_MOVE)


@dataclass(frozen=True)
class ControllerState:
    """What a controller knows of its axis now.

    Attributes:
        steps: Position [motor steps from coordinate zero]; exact when the axis is at rest.
        moving: Whether a move or a homing is under way: from the return of `begin_move` or
            `begin_homing` on, until the axis is at rest.
        homed: Whether the position refers to the zero of the axis. False after a homing that
            failed or was stopped, and after the controller was restarted.
        endstop_pressed: Whether the endstop is pressed; None if the controller does not say.
    """

    steps: int
    moving: bool
    homed: bool
    endstop_pressed: Optional[bool] = None


class AxisController(Protocol):
    """Moves one axis and counts its steps.

    The configuration names the class; it is made with the parameters of the axis and the
    `controller_options`, as keyword arguments. It may open its link then, and raises
    `ControllerError` if it cannot. Each of its methods ends within 3 s and raises
    `ControllerError` if the controller does not answer, reports a fault, or may have lost its
    position. After such an error only `close` is called.

    The limits of the travel, the time limits and the clients are not its task: the driver checks
    them and calls `stop`.
    """

    @property
    def name(self) -> str:
        """What diagnostics and recordings call it, such as "GRBL 1.1h"."""

    def read(self) -> ControllerState:
        """Return the state now.

        Called about every 20 ms in a motion and every 100 ms at rest. A controller that is not
        asked for 2 s, because the driver has died, must end its move with its ramp.
        """

    def begin_move(self, steps: int) -> None:
        """Begin to move to a position, with a ramp; return at once.

        The axis is at rest and homed, and the position is within its travel.
        """

    def begin_homing(self) -> None:
        """Begin to find the zero at a low speed, for a bounded distance; return at once.

        At its end the axis rests within its travel.
        """

    def stop(self) -> None:
        """Begin to end the move with its ramp, or the homing; return at once.

        The position of a move stays exact. Nothing happens to an axis at rest.
        """

    def close(self) -> None:
        """End any motion and release the link; never raises."""


def check_controller(parameters: AxisParameters) -> Callable[[], AxisController]:
    """Return what makes the controller that the parameters name; it is not made yet.

    Raises:
        InvalidValueError: It cannot be imported, is no controller, or has other options.
    """
    name, options = parameters.controller, parameters.controller_options
    kind = load_extension("controller", name, AxisController, 1, options)
    return lambda: kind(parameters, **options)


def open_axis(
    parameters: AxisParameters, watch: Callable[[ControllerMotions], object] = lambda _motions: None
) -> AxisDriver:
    """Return the driver of an axis that a controller moves, and open its link.

    `watch` is called before that; it ends the process once a call is `overdue`.

    Raises:
        InvalidValueError: See `check_controller`.
        AxisException: The controller cannot be reached.
    """
    motions = ControllerMotions(parameters, check_controller(parameters))
    watch(motions)
    motions.open()
    return AxisDriver(parameters, motions, motions.home)


class ControllerMotions:
    """Carries out motions with an `AxisController`, and watches it; an `AxisMotions`.

    One thread reads the state all the time, which also shows the controller that the driver is
    alive. After an error the controller is closed; the next homing makes a new one.
    """

    zero: ZeroEpoch = UNKNOWN_ZERO
    endstop_presses = 0
    failure: Optional[Message] = None

    def __init__(self, parameters: AxisParameters, make: Callable[[], AxisController]) -> None:
        """Make no controller yet; `open` does."""
        self._parameters, self._make = parameters, make
        self._changed = threading.Condition()
        self._calls = threading.Lock()
        self._called_s = 0.0
        self._closed = threading.Event()
        self._state = ControllerState(0, moving=False, homed=False)

    def open(self) -> None:
        """Make the controller; motions are possible on return. Raises as `open_axis`."""
        with self._calling():
            self._make_controller()
        self._reader = threading.Thread(target=self._keep_reading, daemon=True)
        self._reader.start()

    @property
    def overdue(self) -> bool:
        """Whether a call of the controller does not return; only the end of this process helps."""
        called_s = self._called_s
        return called_s > 0.0 and time.monotonic() - called_s > CALL_LIMIT_S

    @property
    def hardware(self) -> Hardware:
        return Hardware(self._controller.name)

    @property
    def steps(self) -> int:
        return self._state.steps

    @property
    def trusted(self) -> bool:
        return self._state.homed and self.failure is None

    @property
    def endstop_pressed(self) -> Optional[bool]:
        return self._state.endstop_pressed if self.failure is None else None

    @property
    def scheduling(self) -> Message:
        return Message("the controller {name} moves the axis", name=self._controller.name)

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the axis is at rest.

        Raises:
            ControllerError: The controller failed; the axis must be homed again.
            NotHomedError: The axis does not rest where it should.
        """
        start, began_s = self.steps, time.monotonic()
        target = start + (motion.steps if motion.forward else -motion.steps)
        self._ask(lambda: self._controller.begin_move(target))
        expected_s = motion.ramp.duration_s(motion.steps)
        ending = self._wait_for_rest(stop_requested, expected_s, motion.guarded)
        if not self._state.homed or (ending is Ending.COMPLETE and self.steps != target):
            lost = Message(
                "the controller ended a move to {target:.12g} {unit} at {coordinate:.12g} {unit}; "
                "home the axis",
                target=self._parameters.coordinate_of(target),
                coordinate=self._parameters.coordinate_of(self.steps),
                unit=self._parameters.unit,
            )
            self._set_failure(lost.with_fault(NOT_HOMED))
            raise NotHomedError(lost)
        if ending is Ending.STOPPED and self.steps == target:
            ending = Ending.COMPLETE
        made, pressed = abs(self.steps - start), bool(self._state.endstop_pressed)
        return MotionReport(ending, made, pressed, time.monotonic() - began_s)

    def home(self, stop_requested: StopRequested) -> None:
        """Let the controller find the zero; the axis then rests within its travel.

        Raises:
            EndstopError: The controller did not find it.
            MotionStopped: A stop was requested.
            ControllerError: The controller failed.
        """
        parameters = self._parameters
        backoff = max(1, parameters.distance_steps(parameters.homing_backoff))
        steps = TRAVEL_MARGIN * parameters.travel_steps + HOMING_BACKOFFS * backoff
        self._ask(self._controller.begin_homing)
        # At the lowest speed.
        expected_s = 2.0 * parameters.max_step * steps
        ending = self._wait_for_rest(stop_requested, expected_s, guarded=False)
        if ending is not Ending.COMPLETE:
            raise MotionStopped(Message("homing was stopped; the axis is not homed"))
        coordinate = parameters.coordinate_of(self.steps)
        if not self._state.homed or not parameters.min_coord <= coordinate <= parameters.max_coord:
            raise EndstopError(
                Message(
                    "the controller did not find the zero of this axis; check the motor and its "
                    "power, the endstop and its cable, and home the axis"
                )
            )

    def begin_zero(self, _steps: int, time_us: int) -> None:
        self.zero = ZeroEpoch(self.zero.number + 1, time_us)

    def distrust(self) -> None:
        """Leave it to the controller, which alone knows where its axis is."""

    def revive(self) -> None:
        if self.failure is not None:
            with self._calling():
                # A link that has failed may fail again here; there is nothing more to do with it.
                with contextlib.suppress(Exception):
                    self._controller.close()
                self._make_controller()
            self._set_failure(None)

    def close(self) -> None:
        self._closed.set()
        self._reader.join(CALL_LIMIT_S)
        # A call that does not return ends with the process.
        if not self._reader.is_alive():
            with contextlib.suppress(ControllerError), self._calling():
                self._controller.close()

    def _make_controller(self) -> None:
        self._controller = self._make()
        self._state = self._controller.read()

    @contextlib.contextmanager
    def _calling(self) -> Iterator[None]:
        """Call the controller, one thread at a time; whatever it raises is a failure."""
        with self._calls:
            self._called_s = time.monotonic()
            try:
                yield
            except Exception as error:  # a class that is not ours may raise anything
                reason = FAILED.with_details(f"{type(error).__name__}: {error}")
                if isinstance(error, ControllerError):
                    reason = error.message
                # Before the next call, which must not move anything any more.
                self._set_failure(reason)
                raise ControllerError(reason) from error
            finally:
                self._called_s = 0.0

    def _ask(self, command: Callable[[], None] = lambda: None) -> None:
        """Give the controller a command, and read its state before anybody looks at it."""
        with self._calling():
            self._check()
            command()
            self._note(self._controller.read())

    def _check(self) -> None:
        if self.failure is not None:
            raise ControllerError(self.failure)

    def _wait_for_rest(
        self, stop_requested: StopRequested, expected_s: float, guarded: bool
    ) -> Ending:
        """Wait until the axis is at rest, as it should be after a time [s].

        Return why it was stopped, or that it was not; guarded, a pressed endstop stops it, too.
        """
        ending = Ending.COMPLETE
        deadline_s = time.monotonic() + SLOWEST_FACTOR * expected_s + MARGIN_S
        state = self._state
        while state.moving:
            if ending is Ending.COMPLETE:
                if guarded and state.endstop_pressed:
                    ending = Ending.PRESSED
                elif stop_requested():
                    ending = Ending.STOPPED
                if ending is not Ending.COMPLETE:
                    self._ask(self._controller.stop)
                    deadline_s = min(deadline_s, time.monotonic() + MARGIN_S)
            if time.monotonic() > deadline_s:
                with contextlib.suppress(ControllerError):
                    self._ask(self._controller.stop)
                self._set_failure(LATE)
            with self._changed:
                while self._state is state and self.failure is None:
                    self._changed.wait()
                self._check()
                state = self._state
        return ending

    def _keep_reading(self) -> None:
        while not self._closed.wait(MOVING_PERIOD_S if self._state.moving else RESTING_PERIOD_S):
            if self.failure is None:
                with contextlib.suppress(ControllerError):  # it is the failure now
                    self._ask()

    def _note(self, state: ControllerState) -> None:
        with self._changed:
            before, self._state = self._state, state
            self.endstop_presses += bool(state.endstop_pressed and not before.endstop_pressed)
            self._changed.notify_all()
        if before.homed and not (state.homed or state.moving or before.moving):
            raise ControllerError(
                Message("the controller has lost the zero of this axis; home the axis"),
                fault=NOT_HOMED,
            )

    def _set_failure(self, reason: Optional[Message]) -> None:
        with self._changed:
            self.failure = reason
            self._changed.notify_all()
