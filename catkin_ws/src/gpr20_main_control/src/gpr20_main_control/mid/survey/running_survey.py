"""The survey that runs now: what the parts that carry it out share."""

from __future__ import annotations

from typing import Callable, Optional

from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.message import Message
from gpr20_main_control.mid.devices.axis_leases import AxisLeases
from gpr20_main_control.mid.devices.positioner import Positioner
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.survey.drift_record import DriftLimits
from gpr20_main_control.mid.survey.survey_coverage import Coverage
from gpr20_main_control.mid.survey.survey_notes import SurveyNotes
from gpr20_main_control.mid.survey.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey.survey_report import (
    AnalyzerRecord,
    SurveyReport,
)
from gpr20_main_control.mid.survey.survey_status import SurveyStatus
from gpr20_main_control.mid.survey.survey_steps import SurveyProgress
from gpr20_main_control.mid.survey.zero_record import ZeroRecord
from gpr20_main_control.mid.waits import Interruption, WaitStatus
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.trace.trace import Trace

# Less than this is how a time server usually corrects a clock [s].
LARGEST_CORRECTION_S = 2.0
# Less than this is the resolution of a clock [us].
ORDER_TOLERANCE_US = 10_000


class ClockSteps:
    """Compares the time of day with a clock that nobody sets, and traces with each other."""

    def __init__(
        self, clock: Clock, last: Optional[Trace], on_step: Callable[[Message], None]
    ) -> None:
        """Begin to compare.

        Args:
            clock: Has both times.
            last: The trace that was stored last, perhaps by another session; None if none is.
            on_step: Called with what happened to the clock.
        """
        self._clock = clock
        self._on_step = on_step
        self._last_us = 0 if last is None else last.timestamp_us
        self._offset_s = self._offset_now_s()

    def check(self) -> Optional[Message]:
        """Return how the clock was set since the last check; None if it was not."""
        offset_s = self._offset_now_s()
        step_s, self._offset_s = offset_s - self._offset_s, offset_s
        if step_s < -LARGEST_CORRECTION_S:
            # The order of the next trace is said herewith.
            self._last_us = 0
            return self._announce(
                Message(
                    "the computer's clock was set back by {step_s:.0f} s during the survey; times "
                    "in the recording are out of order",
                    step_s=-step_s,
                ).with_fault(CLOCK_WRONG.as_warning())
            )
        if step_s > LARGEST_CORRECTION_S:
            return self._announce(
                Message(
                    "the computer's clock was set forward by {step_s:.0f} s during the survey; "
                    "durations in the recording are too long",
                    step_s=step_s,
                ).with_fault(CLOCK_WRONG.as_warning())
            )
        return None

    def check_trace(self, timestamp_us: int) -> Optional[Message]:
        """Return what is wrong with the time of a new trace; None if nothing is."""
        message = self.check()
        behind_us, self._last_us = self._last_us - timestamp_us, timestamp_us
        if message is None and behind_us > ORDER_TOLERANCE_US:
            return self._announce(
                Message(
                    "the computer's clock is {step_s:.1f} s behind the last stored trace; times "
                    "in the recording are out of order",
                    step_s=1.0e-6 * behind_us,
                ).with_fault(CLOCK_WRONG.as_warning())
            )
        return message

    def _announce(self, message: Message) -> Message:
        self._on_step(message)
        return message

    def _offset_now_s(self) -> float:
        return 1.0e-6 * self._clock.time_of_day_us() - self._clock.now_s()


class RunningSurvey:
    """What the parts that carry out one survey share; each knows it and nothing of the engine.

    What only one of them needs is its own.

    Attributes:
        plan: What is measured.
        robot: The parts of the robot.
        status: What is shown of the survey.
        interruption: What ends its waits.
        clock: The clock of its waits.
        leases: What reserves its axes.
        positioner: Its axes.
        waits: Shows what takes longer than expected.
        progress: Where the survey is, from which the remaining steps follow.
        analyzers: With which analyzers it is measured.
        zeros: To which zeros of the axes its traces refer.
        drift: How its reference drifts.
        coverage: The state of each planned sample.
        report: What is stored about it beside its traces.
        notes: What is added to its log.
        clock_steps: Notices that the computer's clock was set.
    """

    def __init__(
        self, plan: SurveyPlan, robot: Robot, status: SurveyStatus, interruption: Interruption
    ) -> None:
        """Begin a survey, or continue one from its folder; nothing moves.

        Raises:
            SurveyError: The report of the survey that is resumed cannot be read.
        """
        self.plan = plan
        self.robot = robot
        self.status = status
        self.interruption = interruption
        self.clock = interruption.clock
        self.leases = AxisLeases(robot.axes, interruption.attention)
        self.positioner = Positioner(
            robot.axes, plan.config.axes, interruption, robot.workers, self.leases
        )
        self.waits = WaitStatus(status, interruption)
        self.progress = SurveyProgress(plan)
        self.analyzers = AnalyzerRecord(plan.analyzers)
        self.zeros = ZeroRecord(plan.zeros, plan.config.axes)
        self.coverage = Coverage(plan.total_points, plan.stored_indices)
        former_report = "" if plan.reopened is None else plan.reopened.report_json
        self.drift = DriftLimits(plan.settings)
        self.report = SurveyReport(self.coverage, self.analyzers, self.zeros, former_report)
        self.notes = SurveyNotes()
        # Set last: what was measured before is not a change.
        self.coverage.on_change = status.show_coverage
        self.clock_steps = ClockSteps(self.clock, plan.last, self._note_clock)

    def note_warning(self, warning: Message) -> None:
        """Note a warning, which is stored with the next report."""
        # The survey continues in spite of it, whatever it is.
        self.report.note_warning(warning.as_warning(), time_of_day_us())

    def _note_clock(self, warning: Message) -> None:
        self.notes.add_message(Kind.CLOCK, warning)
        self.show_warning(warning)

    def show_warning(self, warning: Message) -> None:
        """Note a warning and show it until the next survey begins."""
        self.note_warning(warning)
        self.status.set_warning(warning)
