"""The zeros of the axes in one survey: coordinates of different zeros are not mixed unnoticed."""

from __future__ import annotations

from typing import List, Mapping, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.robot import zeros_of
from gpr20_main_control.mid.measured_again import KnownPoint
from gpr20_survey.axes.axis_id import AxisId, ZeroEpoch, Zeros
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import OTHER_ZEROS
from gpr20_survey.plan.zero_history import UNPROVEN, Proof, UsedZeros
from gpr20_survey.trace.sweep import storable_remark

ByAxis = Mapping[AxisId, ZeroEpoch]


class ZeroRecord:
    """The zeros that the traces of one survey refer to, and how each was proven.

    Attributes:
        accept: Whether the operator accepts the next zeros, if they are those of the last question.
        used: The zeros so far, in their order.
    """

    def __init__(
        self, used: Sequence[UsedZeros], parameters: Mapping[AxisId, AxisParameters]
    ) -> None:
        """Begin, or continue, a record."""
        self.accept = False
        self._asked: Optional[Zeros] = None
        self.used: List[UsedZeros] = list(used)
        self._parameters = parameters
        # Since the survey homed the axes last; the leases keep others from homing them meanwhile.
        self._homed: Zeros = ()

    def to_home_again(self, present: ByAxis) -> List[AxisId]:
        """Return the axes that somebody else homed and whose zero this survey can find itself."""
        former = zip(AxisId, self._homed)
        return [
            axis_id
            for axis_id, zero in former
            if self._parameters[axis_id].finds_zero and present[axis_id] != zero
        ]

    def note_homed(self, present: ByAxis) -> None:
        """Note the zeros since every axis is homed; where needed, by this survey."""
        self._homed = zeros_of(present)

    def needs_proof(self, present: ByAxis) -> bool:
        """Return whether these are other zeros than those of the traces."""
        return not self.used or self.used[-1].zeros != zeros_of(present)

    def begin(self, present: ByAxis, next_index: int, time: str) -> None:
        """Take the zeros as they are: there is no trace of others."""
        self.used = [UsedZeros(zeros_of(present), next_index, time, Proof.START)]

    def judge(
        self, present: ByAxis, point: KnownPoint, limit_db: float, next_index: int, time: str
    ) -> None:
        """Take other zeros, if a known point within a limit [dB], or the operator, says so.

        Raises:
            DeviceError: The operator must decide.
        """
        by_hand, agrees = self._set_by_hand(present), point.agrees(limit_db)
        zeros = zeros_of(present)
        accepted = self.accept and self._asked in (None, zeros)
        self.accept = False
        if agrees and not by_hand:
            # Agreeing with traces that nothing proves proves nothing.
            unproven = bool(self.used) and self.used[-1].proof is Proof.ACCEPTED
            proof = Proof.ACCEPTED if unproven else Proof.MEASURED
        elif accepted:
            proof = Proof.ACCEPTED
        else:
            self._asked = zeros
            raise DeviceError(_question(by_hand, agrees, point), fault=OTHER_ZEROS)
        self.used.append(UsedZeros(zeros, next_index, time, proof))

    def check(self, present: Zeros) -> None:
        """Return if these are the zeros since the axes were homed.

        Raises:
            DeviceError: They are not.
        """
        if self._homed == present:
            return
        pairs = zip(AxisId, self._homed, present)
        raise DeviceError(
            Message(
                "the zero of the {axes} axis was found or set again by somebody else; resume the "
                "survey to compare a known point",
                axes=", ".join(axis_id.value for axis_id, one, other in pairs if one != other),
            ),
            fault=faults.MOVED_BY_OTHERS,
        )

    @property
    def remark(self) -> Tuple[str, ...]:
        """The remark on the quality of traces whose zeros nobody has proven; empty if proven."""
        if not self.used or self.used[-1].proof is not Proof.ACCEPTED:
            return ()
        return (storable_remark(str(UNPROVEN)),)

    def _set_by_hand(self, present: ByAxis) -> List[AxisId]:
        """Return the axes whose zero nothing finds, and that have another one than the traces.

        A homing only turns such an axis to the zero that it knows.
        """
        former = zip(AxisId, self.used[-1].zeros if self.used else ())
        return [
            axis_id
            for axis_id, zero in former
            if not self._parameters[axis_id].finds_zero and zero.time_us != present[axis_id].time_us
        ]


def _question(by_hand: Sequence[AxisId], agrees: bool, point: KnownPoint) -> Message:
    if agrees:
        return Message(
            "the zero of the {axes} axis was set by hand; a known point agrees, which does not "
            "prove where the zero is: {repeat}",
            axes=", ".join(one.value for one in by_hand),
            repeat=point.message,
        )
    if point.turned:
        return Message(
            "the antennas seem to be turned: a known point fits another rotation better; {repeat}",
            repeat=point.message,
        )
    return Message(
        "after homing, a known point does not agree with its stored traces: {repeat}",
        repeat=point.message,
    )
