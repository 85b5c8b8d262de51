"""What can go wrong with the network analyzer, for programs."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

_CHECK_CABLE = Message(
    "Check that the VNA is switched on and that its cable is plugged in at both ends."
)
_RIGHT_VNA = Message("Check that the right VNA is connected, and its address in the plan.")
_CONNECT = Message("Connect the VNA: start or resume the survey, or test the VNA on ROBOT.")
_SET_UP = Message("Enter the plan and start the survey: that sets the VNA up.")

FAILED = Fault("vna.failed", remedies.CHECK_VNA)
# The link.
NO_LINK = Fault("vna.no_link", _CHECK_CABLE)
NO_ANSWER = Fault("vna.no_answer", _CHECK_CABLE)
TOO_SLOW = Fault(
    "vna.too_slow",
    Message("Wait one minute, then try again. If it happens again, check the VNA's cable."),
)
CLASS_STUCK = Fault("vna.class_stuck", remedies.RESTART_ROBOT)
BUSY = Fault("vna.busy", remedies.TRY_LATER)
SUPERSEDED = Fault("vna.superseded", remedies.TRY_LATER)
SHUTTING_DOWN = Fault("vna.shutting_down", remedies.WAIT_FOR_PART)
LOCKED = Fault(
    "vna.locked",
    Message(
        "Close the other program that uses the VNA. If there is none, switch the VNA off and on."
    ),
)
NOT_CONNECTED = Fault("vna.not_connected", _CONNECT)
UNUSED = Fault(
    "vna.unused",
    Message("Nothing to do: a survey connects the VNA when it starts."),
    Severity.NOTE,
)
ANSWERS_AGAIN = Fault(
    "vna.answers_again",
    Message("Nothing to do now. If it happens again, check the VNA's cable at both ends."),
    Severity.WARNING,
)
# The instrument.
WRONG_INSTRUMENT = Fault("vna.wrong_instrument", _RIGHT_VNA)
REPLACED = Fault(
    "vna.replaced",
    remedies.SAME_VNA,
)
# Its settings.
NOT_CONFIGURED = Fault("vna.not_configured", _SET_UP)
SETTING_REFUSED = Fault("vna.setting_refused", remedies.HANDS_OFF_VNA)
SETTINGS_CHANGED = Fault("vna.settings_changed", remedies.HANDS_OFF_VNA)
SETTING_UNREPORTED = Fault(
    "vna.setting_unreported",
    Message("Check on the VNA's display that this setting is right."),
    Severity.WARNING,
)
PROCESSED = Fault(
    "vna.processed",
    Message("Switch smoothing and trace math off on the VNA. Then start or resume the survey."),
)
NOT_AVERAGING = Fault("vna.not_averaging", Message("Set the number of averages in the plan to 1."))
NOT_LINEAR = Fault(
    "vna.not_linear", Message("Set the VNA to a linear sweep. Then start or resume the survey.")
)
# Its calibration.
CALIBRATION_LOST = Fault(
    "vna.calibration_lost",
    Message(
        "Calibrate the VNA now, with the settings that it has. Then start or resume the survey."
    ),
)
CALIBRATION_UNREPORTED = Fault(
    "vna.calibration_unreported",
    Message(
        "Calibrate the VNA, and ask the person who maintains the robot to change "
        "accepted_calibrations."
    ),
)
# Its sweeps and data.
SWEEP_NOT_ENDED = Fault("vna.sweep_not_ended", remedies.HANDS_OFF_VNA)
SWEEP_UNCONFIRMED = Fault(
    "vna.sweep_unconfirmed",
    Message("If the survey is paused, resume it: that measures the point again."),
)
NOT_AS_PROMISED = Fault(
    "vna.class_not_as_promised",
    Message("Ask the author of the analyzer's class to correct what the check names."),
)
BAD_DATA = Fault("vna.bad_data", remedies.CHECK_VNA)
OLD_DATA = Fault("vna.old_data", remedies.CHECK_VNA)
# Remarks on good data.
WEAK = Fault(
    "vna.weak", Message("Check that the cables of both antennas are tight."), Severity.WARNING
)
STRONG = Fault(
    "vna.strong",
    Message("Check that the VNA was calibrated with these cables and this output power."),
    Severity.WARNING,
)
FLAT = Fault("vna.flat", remedies.CHECK_VNA, Severity.WARNING)
UNUSUAL_DURATION = Fault(
    "vna.unusual_duration",
    Message("Check the IF bandwidth on the VNA's display, and its network cable."),
    Severity.WARNING,
)
