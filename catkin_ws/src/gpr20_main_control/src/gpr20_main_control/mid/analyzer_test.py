"""A test of the analyzer outside a survey: connection, identity, calibration, one sweep."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, TypeVar

import numpy as np

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR
from gpr20_common.message import Message
from gpr20_main_control.errors import StopRequested
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.waits import Interruption
from gpr20_survey.plan.robot_description import ANALYZER
from gpr20_survey.radar.frequency_to_delay import decibels
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings

# What is swept if no survey has been planned yet.
TEST_SWEEP = SweepSettings(600.0e6, 6.0e9, 101)
MICRO = 1.0e-6
# Below any analyzer's noise; a level of nothing has no logarithm.
LOWEST_LEVEL = 1.0e-15

_STOPPED = Message("the test was stopped").with_fault(ASKED_FOR)

Result = TypeVar("Result")


def run_analyzer_test(
    robot: Robot, address: str, settings: SweepSettings, interruption: Interruption
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
        test = replace(test, calibration=call(analyzer.calibration).status.name)
        call(lambda: analyzer.configure(settings))
        unconfirmed = call(analyzer.sweep)
        call(lambda: analyzer.confirm(unconfirmed.number))
        test = _with_sweep(test, unconfirmed.sweep)
    except StopRequested:
        test = replace(test, failure=_STOPPED)
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
        sweep_duration_s=MICRO * (sweep.sweep_ended_us - sweep.sweep_started_us),
        level_db=float(decibels(level, LOWEST_LEVEL)),
    )
