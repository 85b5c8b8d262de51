"""The motions of an axis whose pulses are made in the calling thread, without a process."""

from __future__ import annotations

from typing import Any, Optional

from gpr20_axis_driver.motion import Ending, Motion, MotionReport, StopRequested
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware


class DirectPulses:
    """Implements `AxisMotions`; what it does not make itself is asked of the counter.

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

    def __getattr__(self, name: str) -> Any:
        return getattr(self._counter, name)

    def begin_zero(self, steps: int, time_us: int) -> None:
        self._counter.begin_zero(time_us)
        self._counter.place(steps)

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
