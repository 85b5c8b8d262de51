"""The motions of an axis that another controller moves."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import Callable, List, Optional

from gpr20_axis_driver.axis_exceptions import (
    AxisException,
    EndstopError,
    MotionStopped,
    NotHomedError,
)
from gpr20_axis_driver.controller import (
    CALL_LIMIT_S,
    AxisController,
    ControllerError,
    ControllerState,
)
from gpr20_axis_driver.mid.homing import TRAVEL_MARGIN
from gpr20_axis_driver.motion import Ending, Motion, MotionReport, StopRequested
from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import UNKNOWN_ZERO, ZeroEpoch
from gpr20_survey.axes.axis_parameters import HOMING_BACKOFFS, AxisParameters
from gpr20_survey.axes.ramp import Ramp
from gpr20_survey.faults import AXIS_MAY_MOVE, ENDSTOP, NOT_HOMED

MOVING_PERIOD_S = 0.02
RESTING_PERIOD_S = 0.1
# A motion may take this many times its computed duration, and this much longer [s].
SLOWEST_FACTOR = 2.0
MARGIN_S = 5.0
SILENT = Message(
    "the controller of this axis did not answer for {limit_s:g} s; check its power and cable, and "
    "home the axis",
    limit_s=CALL_LIMIT_S,
).with_fault(AXIS_MAY_MOVE)


class _Limits:
    """How long a motion may take, and how long it may take from a stop on [s]."""

    def __init__(self, expected_s: float, brake_s: float) -> None:
        self.motion_s = SLOWEST_FACTOR * expected_s + MARGIN_S
        self.stop_s = SLOWEST_FACTOR * brake_s + MARGIN_S


class ControllerMotions:
    """Carries out motions with an `AxisController`, and watches it; an `AxisMotions`.

    One thread reads the state all the time, which also shows the controller that the driver is
    alive. After an error the controller is closed; the next homing makes a new one.
    """

    def __init__(
        self, parameters: AxisParameters, make: Callable[[AxisParameters], AxisController]
    ) -> None:
        """Make the controller; motions are possible on return.

        Args:
            parameters: The parameters of the axis.
            make: Makes the controller.

        Raises:
            AxisException: The controller cannot be reached.
        """
        self._parameters = parameters
        self._make = make
        self._changed = threading.Condition()
        self._calls = threading.Lock()
        self._closed = threading.Event()
        self._failure: Optional[Message] = None
        # Since when the state is being read [s]; 0: it is not.
        self._asked_s = 0.0
        self._presses = 0
        self._zero = UNKNOWN_ZERO
        self._limited(self._open)
        self._reader = threading.Thread(target=self._keep_reading, daemon=True)
        self._reader.start()

    @property
    def name(self) -> str:
        """What the controller calls itself."""
        return self._controller.name

    @property
    def steps(self) -> int:
        """The position as it was last read [motor steps]."""
        return self._state.steps

    @property
    def trusted(self) -> bool:
        """Whether the position refers to the zero of the axis."""
        return self._state.homed and self.failure is None

    @property
    def failure(self) -> Optional[Message]:
        """Why no motion is possible now; None if one is."""
        with self._changed:
            asked_s = self._asked_s
            if self._failure is None and asked_s and time.monotonic() - asked_s > CALL_LIMIT_S:
                self._failure = SILENT
            return self._failure

    @property
    def endstop_pressed(self) -> Optional[bool]:
        """Whether the endstop is pressed; None if the controller does not say."""
        return self._state.endstop_pressed if self.failure is None else None

    @property
    def endstop_presses(self) -> int:
        """How many times the endstop has closed, as far as it was read."""
        return self._presses

    @property
    def scheduling(self) -> Message:
        """Who makes the pulses."""
        return Message("the controller {name} moves the axis", name=self.name)

    @property
    def unpunctual(self) -> bool:
        """Never: the controller times the pulses."""
        return False

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the axis is at rest.

        Raises:
            ControllerError: The controller failed; the axis must be homed again.
            NotHomedError: The axis does not rest where it should.
        """
        self._check()
        start, ramp = self.steps, motion.ramp
        target = start + (motion.steps if motion.forward else -motion.steps)
        began_s = time.monotonic()
        self._call(lambda: self._controller.begin_move(target))
        brake_s = ramp.duration_s(2 * ramp.braking_steps(ramp.min_pause_s))
        limits = _Limits(ramp.duration_s(motion.steps), brake_s)
        ending = self._wait_for_rest(stop_requested, limits, guarded=motion.guarded)
        if not self._state.homed or (ending is Ending.COMPLETE and self.steps != target):
            lost = self._elsewhere(target)
            self._set_failure(lost)
            raise NotHomedError(lost)
        if ending is Ending.STOPPED and self.steps == target:
            ending = Ending.COMPLETE
        pressed = bool(self._state.endstop_pressed)
        duration_s = time.monotonic() - began_s
        return MotionReport(ending, abs(self.steps - start), pressed, duration_s)

    def home(self, stop_requested: StopRequested) -> None:
        """Let the controller find the zero; the axis then rests within its travel.

        Raises:
            EndstopError: The controller did not find it.
            MotionStopped: A stop was requested.
            ControllerError: The controller failed.
        """
        self._check()
        pause_s = self._parameters.max_step
        slow = Ramp(pause_s, pause_s, self._parameters.delta_step)
        backoff = max(1, self._parameters.distance_steps(self._parameters.homing_backoff))
        steps = int(self._parameters.travel_steps * TRAVEL_MARGIN) + HOMING_BACKOFFS * backoff
        self._call(self._controller.begin_homing)
        limits = _Limits(slow.duration_s(steps), 0.0)
        if self._wait_for_rest(stop_requested, limits, guarded=False) is not Ending.COMPLETE:
            raise MotionStopped(Message("homing was stopped; the axis is not homed"))
        low, high = self._parameters.min_coord, self._parameters.max_coord
        coordinate = self._parameters.coordinate_of(self.steps)
        if not self._state.homed or not low <= coordinate <= high:
            raise EndstopError(
                Message(
                    "the controller did not find the zero of this axis; check the motor and its "
                    "power, the endstop and its cable, and home the axis"
                ),
                fault=ENDSTOP,
            )

    @property
    def zero(self) -> ZeroEpoch:
        """The zero that the position refers to."""
        return self._zero

    def begin_zero(self, time_us: int) -> None:
        """Begin another epoch of the zero, which the controller found then [us since 1970]."""
        self._zero = ZeroEpoch(self._zero.number + 1, time_us)

    def place(self, _steps: int) -> None:
        """Refuse: only a controller knows where its axis is."""
        raise EndstopError(
            Message("the controller determines the zero of this axis; home the axis"),
            fault=NOT_HOMED,
        )

    def distrust(self) -> None:
        """Leave it to the controller, which alone knows where its axis is."""

    def revive(self) -> None:
        """Replace a controller that has failed.

        Raises:
            AxisException: It cannot be reached.
        """
        if self.failure is not None:
            self._limited(self._renew)
            self._set_failure(None)

    def close(self) -> None:
        """End any motion and release the controller."""
        self._closed.set()
        with self._changed:
            self._changed.notify_all()
        self._reader.join(CALL_LIMIT_S)
        # The process ends with a controller that hangs.
        with contextlib.suppress(ControllerError):
            self._limited(self._release)

    def _renew(self) -> None:
        with self._calls:
            self._release()
            self._open()

    def _open(self) -> None:
        try:
            self._controller = self._make(self._parameters)
            self._state = self._controller.read()
        except Exception as error:  # a class that is not ours may raise anything
            raise ControllerError(self._reason(error)) from error

    def _release(self) -> None:
        # A link that has failed may fail again here, and there is nothing more to do with it.
        with contextlib.suppress(Exception):
            self._controller.close()

    def _check(self) -> None:
        failure = self.failure
        if failure is not None:
            raise ControllerError(failure)

    def _call(self, command: Callable[[], None]) -> None:
        """Give the controller a command, and read its state before anybody looks at it."""

        def give() -> None:
            with self._calls:
                # It may have waited for a call that hung: nothing must move that late.
                self._check()
                command()
                self._note(self._controller.read())

        try:
            self._limited(give)
        except ControllerError as error:
            self._set_failure(error.message)
            raise

    def _limited(self, action: Callable[[], None]) -> None:
        """Carry out what a class that is not ours may never end.

        Raises:
            ControllerError: It failed, or did not end in time.
        """
        failures: List[Exception] = []
        ended = threading.Event()

        def act() -> None:
            try:
                action()
            except Exception as error:  # a class that is not ours may raise anything
                failures.append(error)
            ended.set()

        threading.Thread(target=act, daemon=True).start()
        if not ended.wait(CALL_LIMIT_S):
            raise ControllerError(SILENT)
        if failures:
            raise ControllerError(self._reason(failures[0])) from failures[0]

    def _wait_for_rest(
        self, stop_requested: StopRequested, limits: _Limits, guarded: bool
    ) -> Ending:
        """Wait until the axis is at rest; return why it was stopped, or that it was not."""
        ending = Ending.COMPLETE
        deadline_s = time.monotonic() + limits.motion_s
        state = self._state
        while state.moving:
            if ending is Ending.COMPLETE:
                ending = self._wanted_end(stop_requested, guarded)
                if ending is not Ending.COMPLETE:
                    self._call(self._controller.stop)
                    deadline_s = min(deadline_s, time.monotonic() + limits.stop_s)
            if time.monotonic() > deadline_s:
                self._end_late()
            state = self._next_state(state)
        return ending

    def _wanted_end(self, stop_requested: StopRequested, guarded: bool) -> Ending:
        if guarded and self._state.endstop_pressed:
            return Ending.PRESSED
        return Ending.STOPPED if stop_requested() else Ending.COMPLETE

    def _end_late(self) -> None:
        late = Message(
            "the controller of this axis did not end a motion in time; check the motor and the "
            "endstop, and home the axis"
        ).with_fault(AXIS_MAY_MOVE)
        with contextlib.suppress(ControllerError):
            self._call(self._controller.stop)
        self._set_failure(late)
        raise ControllerError(late)

    def _next_state(self, state: ControllerState) -> ControllerState:
        with self._changed:
            answered = self._changed.wait_for(
                lambda: self._state is not state or self._failure is not None, CALL_LIMIT_S
            )
        if not answered:
            self._set_failure(SILENT)
        self._check()
        return self._state

    def _keep_reading(self) -> None:
        while not self._closed.wait(MOVING_PERIOD_S if self._state.moving else RESTING_PERIOD_S):
            if self.failure is not None:
                continue
            try:
                with self._calls:
                    self._asked_s = time.monotonic()
                    self._note(self._controller.read())
            except Exception as error:  # a class that is not ours may raise anything
                self._set_failure(self._reason(error))
            finally:
                self._asked_s = 0.0

    def _note(self, state: ControllerState) -> None:
        with self._changed:
            pressed_before = self._state.endstop_pressed
            lost = self._state.homed and not (state.homed or state.moving or self._state.moving)
            self._presses += bool(state.endstop_pressed and not pressed_before)
            self._state = state
            self._changed.notify_all()
        if lost:
            raise ControllerError(
                Message("the controller has lost the zero of this axis; home the axis"),
                fault=NOT_HOMED,
            )

    def _set_failure(self, reason: Optional[Message]) -> None:
        with self._changed:
            self._failure = reason
            self._changed.notify_all()

    def _elsewhere(self, target: int) -> Message:
        unit = self._parameters.unit
        return Message(
            "the controller ended a move to {target:.12g} {unit} at {coordinate:.12g} {unit}; home "
            "the axis",
            target=self._parameters.coordinate_of(target),
            coordinate=self._parameters.coordinate_of(self.steps),
            unit=unit,
        ).with_fault(NOT_HOMED)

    def _reason(self, error: Exception) -> Message:
        if isinstance(error, AxisException):
            return error.message
        return Message(
            "the controller of this axis failed; see the log and home the axis",
            details=f"{type(error).__name__}: {error}",
        ).with_fault(AXIS_MAY_MOVE)
