"""The daily check as a maintenance: one request for each part, which a stop ends."""

from __future__ import annotations

import os
from typing import Dict, Optional

from gpr20_common.faults import ASKED_FOR, DISK_REFUSES
from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.low.data_folder import state_folder
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, RequestRefusedError, StopRequested
from gpr20_main_control.mid.check_verdict import Verdict
from gpr20_main_control.mid.daily_check import (
    CheckedRobot,
    SweptPart,
    compare_with_history,
    history_folder,
    made_check,
    sweep_part,
)
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.waits import StopInterruption
from gpr20_survey.errors import ProcessingError
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.folder.data_folder import DataFolderUse
from gpr20_survey.plan.robot_description import STORAGE
from gpr20_survey.results.daily_check import Part
from gpr20_survey.trace.utc_time import iso_text

# A check that was not ended within this time [s] is given up.
CHECK_LIMIT_S = 1800.0
STEPS = tuple(Part)


class DailyCheckSteps:
    """Keeps the sweeps of the check in progress; the service slot lets in one step at a time."""

    def __init__(self, robot: Robot, clock: Clock) -> None:
        """Begin without a check."""
        self._robot = robot
        self._clock = clock
        self._begun_s = 0.0
        self._client = ""
        self._parts: Dict[Part, SweptPart] = {}

    def take(self, step: int, client: str, interruption: StopInterruption) -> Optional[Verdict]:
        """Sweep one part.

        Args:
            step: Number of the part; the first begins a new check.
            client: Node that asks; the parts of two do not make one check.
            interruption: What ends the step.

        Returns:
            The verdict after the last part.

        Raises:
            RequestRefusedError: A part before is missing, or too old; nothing was swept.
            DeviceError: The analyzer or the disk failed; the step can be repeated.
            StopRequested: A stop was requested; the step can be repeated.
            InvalidValueError: The parts of the robot have not described themselves.
        """
        part = self._expected(step, client)
        address = self._robot.description.analyzer_address()
        self._parts[part] = self._sweep(address, interruption)
        return self._end(address) if part is STEPS[-1] else None

    def _expected(self, step: int, client: str) -> Part:
        if step == 0:
            self._parts.clear()
            self._begun_s, self._client = self._clock.now_s(), client
        elif self._clock.now_s() - self._begun_s > CHECK_LIMIT_S:
            self._parts.clear()
        missing = any(before not in self._parts for before in STEPS[:step])
        if step >= len(STEPS) or missing or client != self._client:
            raise RequestRefusedError(
                Message("a step before this one is missing, or too old"), fault=CHECK_ORDER
            )
        return STEPS[step]

    def _sweep(self, address: str, interruption: StopInterruption) -> SweptPart:
        calls, analyzer = self._robot.analyzer_calls, self._robot.analyzer
        try:
            return sweep_part(analyzer, address, lambda one: calls.call(one, interruption.check))
        except StopRequested as error:
            raise StopRequested(Message("the test was stopped"), fault=ASKED_FOR) from error
        finally:
            # Without waiting: behind a call that hangs it comes late, but before any later call.
            calls.begin(analyzer.release)

    def _end(self, address: str) -> Verdict:
        description = self._robot.description
        robot = CheckedRobot(description.site.robot, description.config().simulated, address)
        nodes = description.nodes
        stored = nodes[STORAGE].configuration.get("data", "") if STORAGE in nodes else ""
        data = DataFolderUse(history_folder(stored, os.environ), state_folder(os.environ))
        try:
            verdict, _damaged = compare_with_history(
                made_check(self._parts), robot, data, iso_text(time_of_day_us())
            )
        except ProcessingError as error:
            raise DeviceError(
                Message("the check could not be made: {reason}", reason=error.message)
            ) from error
        except OSError as error:
            raise DeviceError(
                Message("the check could not be made: {reason}", reason=str(error)), DISK_REFUSES
            ) from error
        self._parts.clear()
        return verdict
