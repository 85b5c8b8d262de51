"""What another controller of an axis must do: a class outside this repository implements it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Protocol

from gpr20_axis_driver.axis_exceptions import AxisException
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import AXIS_MAY_MOVE

# The longest that any method of a controller may take [s].
CALL_LIMIT_S = 3.0


class ControllerError(AxisException, OSError):
    """The controller does not answer, or reports a fault: the position is no longer known."""

    fault = AXIS_MAY_MOVE


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
    `ControllerError` if it cannot. Its methods are called by one thread at a time; each ends
    within 3 s and raises `ControllerError` if the controller does not answer, reports a fault, or
    may have lost its position. After such an error only `close` is called.

    The limits of the travel, the time limits and the clients are not its task: the driver checks
    them and calls `stop`.
    """

    def __init__(self, parameters: AxisParameters) -> None:
        """Open the link; further arguments are the options."""

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
