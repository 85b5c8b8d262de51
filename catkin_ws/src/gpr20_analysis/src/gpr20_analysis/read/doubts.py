"""What is doubted of a survey although every trace of it is readable."""

from __future__ import annotations

from typing import Any, List, Mapping, Sequence

from gpr20_analysis import faults
from gpr20_common.message import Message
from gpr20_survey.axes.zero_epoch import Zeros
from gpr20_survey.plan.zero_history import UNPROVEN, ZEROS, unproven_zeros


def unproven_positions(report: Any, zeros: Sequence[Zeros]) -> int:
    """Return of how many traces the positions refer to zeros that nothing proves.

    Args:
        report: The report in survey.json as it was read; anything may stand there.
        zeros: Those of the traces, in the order of their indices.
    """
    unproven = unproven_zeros(report, zeros)
    return sum(one in unproven for one in zeros)


def positions_note(count: int) -> Message:
    """Return what is said of so many traces with positions that nothing proves."""
    return Message(
        "{count} traces refer to zeros of the axes that no measurement proved to be those of "
        "the others: their positions and rotations may be wrong",
        count=count,
    ).with_fault(faults.ZEROS_UNPROVEN)


def position_doubts(
    report: Any, zeros: Sequence[Zeros], remarks: Sequence[Sequence[str]]
) -> List[Message]:
    """Return the doubts about the positions of traces that were read.

    Args:
        report: As above; a recording that ended early has none, or an older one.
        zeros: As above.
        remarks: The remarks of the robot on the quality of each trace, which say it too.
    """
    listed = isinstance(report, Mapping) and bool(report.get(ZEROS))
    marked = sum(str(UNPROVEN) in one for one in remarks)
    count = max(marked, unproven_positions(report, zeros) if listed else 0)
    return [positions_note(count)] if count else []
