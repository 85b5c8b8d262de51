"""Checks of the VNA: its identity and its calibration."""

from __future__ import annotations

from typing import Dict, Iterator

from gpr20_common.message import Fault, Message, verbatim
from gpr20_doctor import faults
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.faults import CALIBRATION_AGED, NOT_CALIBRATED
from gpr20_survey.plan.robot_description import ANALYZER, is_simulated_identity
from gpr20_survey.trace.calibration import CalibrationStatus

TEST = Message("A survey reads it; or test the VNA on SERVICE.")
CALIBRATION_FAULTS: Dict[CalibrationStatus, Fault] = {
    CalibrationStatus.NONE: NOT_CALIBRATED,
    CalibrationStatus.MODERATE_POWER: CALIBRATION_AGED,
    CalibrationStatus.MODERATE_TEMPERATURE: CALIBRATION_AGED,
    CalibrationStatus.LOW: CALIBRATION_AGED,
    CalibrationStatus.NOT_REPORTED: faults.CALIBRATION_UNKNOWN,
}


def check_analyzer(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the test of the VNA, or what its driver reports where it was not tested."""
    test = facts.analyzer
    if test is not None and test.failure is not None:
        text = Message("Test of the VNA: {reason}", reason=test.failure)
        yield Finding.of_fault("vna", text.with_fault(faults.VNA_TEST_FAILED))
    known = facts.reported(ANALYZER) if test is None else test
    identity, calibration = ("", "") if known is None else (known.identity, known.calibration)
    if identity:
        yield _identity(identity, facts.simulated)
    if calibration or test is None or test.failure is None:
        yield _calibration(calibration)


def _calibration(name: str) -> Finding:
    if not name:
        text = Message("The calibration of the VNA has not been read yet.")
        return Finding("calibration", Level.UNKNOWN, text, TEST)
    status = CalibrationStatus.named(name)
    state = verbatim(name) if status is None else status.meaning
    text = Message("Calibration of the VNA: {state}", state=state)
    if status is None:
        remedy = faults.CALIBRATION_UNKNOWN.remedy
        return Finding("calibration", Level.UNKNOWN, text, remedy)
    fault = CALIBRATION_FAULTS.get(status)
    if fault is None:
        return Finding("calibration", Level.OK, text)
    return Finding.of_fault("calibration", text.with_fault(fault))


def _identity(identity: str, simulated: bool) -> Finding:
    if is_simulated_identity(identity) == simulated:
        return Finding("identity", Level.OK, Message("VNA: {identity}", identity=identity))
    text = Message(
        "The VNA {identity} and the robot are not both simulated or both real.",
        identity=identity,
    )
    return Finding.of_fault("identity", text.with_fault(faults.IDENTITY_WRONG))
