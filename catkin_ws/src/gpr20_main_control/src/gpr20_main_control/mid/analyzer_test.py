"""A test of the analyzer outside a survey: connection, identity, calibration, one sweep."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, Optional, TypeVar

import numpy as np

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_main_control.errors import StopRequested
from gpr20_main_control.mid.interruption import StopInterruption
from gpr20_main_control.mid.robot import Robot
from gpr20_survey.plan.robot_description import ANALYZER
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings

# What is swept if no survey has been planned yet.
TEST_SWEEP = SweepSettings(600.0e6, 6.0e9, 101)
MICRO = 1.0e-6
# Below any analyzer's noise; a level of nothing has no logarithm.
LOWEST_LEVEL = 1.0e-15

Result = TypeVar("Result")


@dataclass(frozen=True)
class AnalyzerTest:
    """What a test of the analyzer has found.

    Attributes:
        address: Where the analyzer was looked for.
        identity: What it says it is; empty: no connection.
        calibration: Its state; None: not read, or not accepted.
        points: Frequencies of the sweep; 0: there was none.
        duration_s: From the trigger to the end of the sweep [s].
        level_db: Median of S21 [dB].
        failure: Why the test ended early; None: it did not.
    """

    address: str
    identity: str = ""
    calibration: Optional[CalibrationStatus] = None
    points: int = 0
    duration_s: float = 0.0
    level_db: float = 0.0
    failure: Optional[Message] = None


def run_analyzer_test(
    robot: Robot, address: str, settings: SweepSettings, interruption: StopInterruption
) -> AnalyzerTest:
    """Test the analyzer and release it; nothing moves.

    Args:
        robot: The parts of the robot.
        address: Of the analyzer; empty: as the robot is configured.
        settings: What to sweep.
        interruption: What ends the test.

    Returns:
        What was found, up to the first failure.
    """
    nodes, analyzer = robot.description.nodes, robot.analyzer
    if not address and ANALYZER in nodes:
        address = str(nodes[ANALYZER].configuration.get("address", ""))
    test = AnalyzerTest(address)

    def call(one: Callable[[], Result]) -> Result:
        return robot.analyzer_calls.call(one, interruption.check)

    try:
        test = replace(test, identity=call(lambda: analyzer.connect(address)))
        if robot.description.problem() is None:
            robot.description.check_identity(test.identity, robot.description.config())
        test = replace(test, calibration=call(analyzer.calibration))
        call(lambda: analyzer.configure(settings))
        unconfirmed = call(analyzer.sweep)
        call(lambda: analyzer.confirm(unconfirmed.number))
        test = _with_sweep(test, unconfirmed.sweep)
    except StopRequested:
        test = replace(test, failure=Message("the test was stopped"))
    except Gpr20Error as error:
        test = replace(test, failure=error.message)
    # Without waiting: behind a call that hangs it comes late, but before any later call.
    robot.analyzer_calls.begin(analyzer.release)
    return test


def _with_sweep(test: AnalyzerTest, sweep: Sweep) -> AnalyzerTest:
    level = float(np.median(np.hypot(sweep.s21_real, sweep.s21_imag)))
    return replace(
        test,
        points=len(sweep.frequency_hz),
        duration_s=MICRO * (sweep.sweep_ended_us - sweep.sweep_started_us),
        level_db=float(20.0 * np.log10(max(level, LOWEST_LEVEL))),
    )
