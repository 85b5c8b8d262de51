"""The zeros of the axes in one survey: coordinates of different zeros are not mixed unnoticed."""

from __future__ import annotations

from typing import List, Mapping, Optional, Sequence, Set, Tuple

from gpr20_common.message import Message
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.robot import zeros_of
from gpr20_main_control.mid.survey.known_point import KnownPoint
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
        # Found by a homing of this survey.
        self._own: Set[Tuple[AxisId, ZeroEpoch]] = set()

    def foreign(self, present: ByAxis) -> List[AxisId]:
        """Return the axes whose zero is neither that of the traces nor found by this survey."""
        return [axis_id for axis_id, zero in present.items() if self._is_foreign(axis_id, zero)]

    def to_home_again(self, present: ByAxis) -> List[AxisId]:
        """Return the axes that somebody else homed and whose zero this survey can find itself."""
        return [one for one in self.foreign(present) if self._parameters[one].finds_zero]

    def note_homed(self, homed: Sequence[AxisId], present: ByAxis) -> None:
        """Note which axes the survey homed, and the zeros since."""
        self._own.update((axis_id, present[axis_id]) for axis_id in homed)

    def needs_proof(self, present: ByAxis) -> bool:
        """Return whether these are other zeros than those of the traces."""
        return not self.used or self.used[-1].zeros != zeros_of(present)

    def begin(self, present: ByAxis, next_index: int, time: str) -> None:
        """Take the zeros as they are: there is no trace of others."""
        self.used = [UsedZeros(zeros_of(present), next_index, time, Proof.START)]

    def judge(
        self, present: ByAxis, point: KnownPoint, limit_db: float, next_index: int, time: str
    ) -> None:
        """Take other zeros, if a known point and the operator say so.

        Args:
            present: The zeros now.
            point: The known point, measured again.
            limit_db: The largest difference with which it agrees [dB].
            next_index: Index of the next trace.
            time: The time of day.

        Raises:
            DeviceError: The operator must decide.
        """
        foreign, agrees = self.foreign(present), point.agrees(limit_db)
        zeros = zeros_of(present)
        accepted = self.accept and self._asked in (None, zeros)
        self.accept = False
        if agrees and not foreign:
            # Agreeing with traces that nothing proves proves nothing.
            unproven = bool(self.used) and self.used[-1].proof is Proof.ACCEPTED
            proof = Proof.ACCEPTED if unproven else Proof.MEASURED
        elif accepted:
            proof = Proof.ACCEPTED
        else:
            self._asked = zeros
            raise DeviceError(_question(foreign, agrees, point), fault=OTHER_ZEROS)
        self.used.append(UsedZeros(zeros, next_index, time, proof))

    def check(self, present: Zeros) -> None:
        """Return if these are the zeros of the traces.

        Raises:
            DeviceError: They are not.
        """
        if self.used and self.used[-1].zeros != present:
            pairs = zip(AxisId, self.used[-1].zeros, present)
            changed = [axis_id.value for axis_id, one, other in pairs if one != other]
            raise DeviceError(
                Message(
                    "the zero of the {axes} axis was found or set again by somebody else; "
                    "resume the survey to compare a known point",
                    axes=", ".join(changed),
                ),
                fault=faults.MOVED_BY_OTHERS,
            )

    @property
    def remark(self) -> Tuple[str, ...]:
        """The remark on the quality of traces whose zeros nobody has proven; empty if proven."""
        if not self.used or self.used[-1].proof is not Proof.ACCEPTED:
            return ()
        return (storable_remark(str(UNPROVEN)),)

    def _is_foreign(self, axis_id: AxisId, zero: ZeroEpoch) -> bool:
        if not self.used or not self.used[-1].zeros:
            return False
        used = self.used[-1].zeros[list(AxisId).index(axis_id)]
        if self._parameters[axis_id].finds_zero:
            return zero != used and (axis_id, zero) not in self._own
        # A homing only turned it to the zero that it knew.
        return zero.time_us != used.time_us


def _question(foreign: Sequence[AxisId], agrees: bool, point: KnownPoint) -> Message:
    axes = ", ".join(one.value for one in foreign)
    if agrees:
        return Message(
            "the zero of the {axes} axis was set by hand; a known point agrees, which does not "
            "prove where the zero is: {repeat}",
            axes=axes,
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
