"""The motions of an axis whose pulses are made in the calling thread, without a process."""

from __future__ import annotations

from typing import Any, Optional

from gpr20_axis_driver.motion import Ending, Motion, MotionReport, StopRequested
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes.axis_id import ZeroEpoch


class DirectPulses:
    """Implements `AxisMotions`.

    Args:
        runner: Makes the pulses: a `PulseLoop`.
        counter: Counts them: a `StepCounter`, or what stands for it.
    """

    failure: Optional[Message] = None
    scheduling = Message("ordinary")
    hardware = Hardware("pins")

    def __init__(self, runner: Any, counter: Any) -> None:
        self._runner, self._counter = runner, counter
        self.distrust = counter.begin

    @property
    def steps(self) -> int:
        return int(self._counter.steps)

    @property
    def trusted(self) -> bool:
        return bool(self._counter.trusted)

    @property
    def zero(self) -> ZeroEpoch:
        zero: ZeroEpoch = self._counter.zero
        return zero

    def begin_zero(self, steps: int, time_us: int) -> None:
        self._counter.begin_zero(time_us)
        self._counter.place(steps)

    @property
    def endstop_pressed(self) -> Optional[bool]:
        pressed: Optional[bool] = self._counter.endstop_pressed
        return pressed

    @property
    def endstop_presses(self) -> int:
        return int(self._counter.endstop_presses)

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        exact = self.trusted
        report: MotionReport = self._runner.run(motion, stop_requested)
        assert self.trusted == (exact and report.ending is not Ending.GAP)
        return report

    def revive(self) -> None:
        pass

    def close(self) -> None:
        self._runner.close()
        self._counter.close()
