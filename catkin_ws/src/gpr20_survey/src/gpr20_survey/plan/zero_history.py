"""The zeros that the traces of a survey refer to, as its report lists them."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import Zeros, are_zeros

# The entry of the report.
ZEROS = "zeros"
UNPROVEN = Message("the zeros of the axes are not proven to be those of the traces before")
"""The remark on the quality of a trace whose zeros nobody has proven."""


class Proof(enum.Enum):
    """How it is known that the coordinates of other zeros are those of the survey."""

    START = "start"
    """They are the zeros of the first trace."""
    MEASURED = "measured"
    """The survey homed the axes itself, and a known point agreed at every rotation."""
    ACCEPTED = "accepted"
    """Nothing proves it; the operator decided to continue."""


@dataclass(frozen=True)
class UsedZeros:
    """Zeros of a part of a survey.

    Attributes:
        from_index: Index of the first trace that was to be measured with them.
        time: When the survey began to use them, ISO 8601.
        proof: How it is known that they are where the former ones were.
    """

    zeros: Zeros
    from_index: int
    time: str
    proof: Proof

    def __post_init__(self) -> None:
        if not are_zeros(self.zeros):
            raise InvalidValueError(Message("zeros are not those of three axes"))
