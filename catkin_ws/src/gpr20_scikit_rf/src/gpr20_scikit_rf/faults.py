"""The faults that only analyzers of other makers have; the others are those of any analyzer."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

LIBRARY_UNUSABLE = Fault(
    "vna.library_unusable",
    Message("Ask the person who maintains the robot to install what the message names."),
)
NOT_UNDERSTOOD = Fault(
    "vna.not_understood",
    Message("Ask the person who maintains the robot to check how the VNA is configured."),
)
SETTING_UNAVAILABLE = Fault(
    "vna.setting_unavailable",
    Message(
        "Correct the value if the plan has it. If not, ask the person who maintains the robot to "
        "check how the VNA is configured."
    ),
)
CALIBRATION_UNSURE = Fault(
    "vna.calibration_unsure",
    Message("Look on the VNA's display whether the calibration still applies; if not, repeat it."),
    Severity.WARNING,
)
SWEEP_TOO_EARLY = Fault("vna.sweep_too_early", remedies.CHECK_VNA)
