"""What an axis says about its motion."""

from __future__ import annotations

from dataclasses import dataclass

from gpr20_survey.axes.axis_id import AxisId


@dataclass(frozen=True)
class AxisReport:
    """The last report of an axis.

    Attributes:
        axis: Which axis.
        moving: Whether it moves.
        owner: Full name of the node that holds it; empty: nobody, or it is not known.
        received_s: When the report came [s].
    """

    axis: AxisId
    moving: bool
    owner: str
    received_s: float
