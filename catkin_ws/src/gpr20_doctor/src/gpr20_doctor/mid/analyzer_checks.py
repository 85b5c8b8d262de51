"""Checks of the VNA: its identity and its calibration."""

from __future__ import annotations

from typing import Dict, Iterator, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.remedies import CHECK_VNA_CABLE, find_remedy
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.plan.robot_description import ANALYZER, is_simulated_identity

CALIBRATE = Message("Calibrate the VNA with the cables of the survey.")
TEST = Message("A survey reads it; or test the VNA on SERVICE.")
CALIBRATIONS: Dict[str, Tuple[Level, Message, Optional[Message]]] = {
    "": (Level.UNKNOWN, Message("The calibration of the VNA has not been read yet."), TEST),
    "NONE": (Level.FAULT, Message("The VNA has no calibration."), CALIBRATE),
    "HIGH": (Level.OK, Message("Calibration of the VNA: high accuracy"), None),
    "MODERATE_POWER": (
        Level.WARNING,
        Message("The VNA's power level has changed since its calibration."),
        CALIBRATE,
    ),
    "MODERATE_TEMPERATURE": (
        Level.WARNING,
        Message("The VNA's temperature has changed by more than 5 °C since its calibration."),
        CALIBRATE,
    ),
    "LOW": (
        Level.WARNING,
        Message("The VNA's temperature has changed by more than 10 °C since its calibration."),
        CALIBRATE,
    ),
    "NOT_REPORTED": (
        Level.WARNING,
        Message("This VNA does not report its calibration."),
        Message("Make sure that it is calibrated."),
    ),
}


def check_analyzer(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the test of the VNA, or what its driver reports where it was not tested."""
    test = facts.analyzer
    if test is not None and test.failure is not None:
        yield Finding(
            "vna",
            Level.FAULT,
            Message("Test of the VNA: {reason}", reason=test.failure),
            find_remedy(test.failure) or CHECK_VNA_CABLE,
        )
    identity = facts.value(ANALYZER, "identity") if test is None else test.identity
    if identity:
        yield _identity(identity, facts.simulated)
    calibration = facts.value(ANALYZER, "calibration") if test is None else test.calibration
    if calibration or test is None or test.failure is None:
        default = Level.WARNING, verbatim(calibration), CALIBRATE
        level, text, remedy = CALIBRATIONS.get(calibration, default)
        yield Finding("calibration", level, text, remedy)


def _identity(identity: str, simulated: bool) -> Finding:
    if is_simulated_identity(identity) == simulated:
        return Finding("identity", Level.OK, Message("VNA: {identity}", identity=identity))
    return Finding(
        "identity",
        Level.FAULT,
        Message(
            "The VNA {identity} and the robot are not both simulated or both real.",
            identity=identity,
        ),
        Message("Check the address of the VNA."),
    )
