"""The zeros that the traces of a survey refer to, as its report lists them."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Mapping, Set

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.axes.zero_epoch import ZeroEpoch, Zeros, are_zeros
from gpr20_survey.trace import utc_time

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
        zeros: Of x, y and z; empty if the axes do not know them.
        from_index: Index of the first trace that was to be measured with them.
        time: When the survey began to use them, ISO 8601.
        proof: How it is known that they are where the former ones were.
    """

    zeros: Zeros
    from_index: int
    time: str
    proof: Proof

    def record(self) -> Dict[str, Any]:
        """Return it as JSON holds it."""
        return {
            "from_index": self.from_index,
            "time": self.time,
            "proof": self.proof.value,
            "epochs": [one.number for one in self.zeros],
            "times": [utc_time.iso_text(one.time_us) for one in self.zeros],
        }


def used_zeros_from(report: Mapping[str, Any]) -> List[UsedZeros]:
    """Return the zeros of a report; reports of earlier versions have none.

    Raises:
        TypeError, ValueError, KeyError: The entry is no such list.
    """
    return [_from_record(one) for one in report.get(ZEROS, [])]


def _from_record(one: Mapping[str, Any]) -> UsedZeros:
    zeros = tuple(
        ZeroEpoch(int(number), utc_time.parse_iso(time))
        for number, time in zip(one["epochs"], one["times"])
    )
    if not are_zeros(zeros):
        raise ValueError("not the zeros of three axes")
    return UsedZeros(zeros, int(one["from_index"]), str(one["time"]), Proof(one["proof"]))


def unproven_zeros(report: Any, measured: Iterable[Zeros]) -> Set[Zeros]:
    """Return the zeros of traces that nothing proves to be those of the traces before.

    Args:
        report: The report as it was read; anything may stand there.
        measured: The zeros of the traces, in the order of their indices; traces of earlier
            versions have none.
    """
    try:
        used = used_zeros_from(report) if isinstance(report, Mapping) else []
    except (TypeError, ValueError, KeyError, AttributeError, InvalidValueError):
        used = []
    known = [one for one in measured if one]
    proven = {one.zeros for one in used if one.proof is not Proof.ACCEPTED}
    # Without a list, the zeros of the first trace are those of the survey.
    if not used and known:
        proven.add(known[0])
    return set(known) - proven
