"""What to do first about a fault, found from the sentences that report it."""

from __future__ import annotations

import re
from typing import Optional, Pattern, Tuple

from gpr20_common.message import Message

MOTORS_OFF = Message("Switch off the motors' power now. Keep your hands clear.")
MAKE_SPACE = Message("Make space on the disk: copy old surveys to a USB stick and delete them.")
CHECK_DISK = Message("Check that the disk is plugged in, not full and not write-protected.")
CHECK_ENDSTOP = Message(
    "Switch off the motors' power. Look for anything that blocks the carriage, and check the "
    "endstop switch, its cable and the belt. Switch the power on again."
)
CHECK_MOTORS = Message(
    "Keep your hands clear. Look for anything that blocks the carriage or holds a cable, and "
    "check the motors' power."
)
SET_ZERO = Message("Turn the antennas to their mark and set the zero of the Z axis.")
LESS_LOAD = Message("End other programs on the robot's computer, and check that it is not hot.")
CHECK_HEIGHT = Message(
    "Check the plug of the height sensor. Remove grass or objects below it, so that it sees the "
    "ground."
)
SAME_VNA = Message("Connect the VNA with which the survey began, or accept the other one.")
RIGHT_VNA = Message("Check that the right VNA is connected, and its address in the plan.")
CALIBRATE = Message("Calibrate the VNA with the cables of the antennas.")
HANDS_OFF_VNA = Message("Set the VNA to VNA mode. Do not touch its keys during a survey.")
CHECK_VNA = Message(
    "Look at the VNA's display. If it looks wrong, switch the VNA off and on and wait until it "
    "has started."
)
CHECK_VNA_CABLE = Message(
    "Check that the VNA is switched on and that its network cable is plugged in at both ends."
)
WAIT_FOR_PART = Message(
    "Wait one minute: the robot restarts the part by itself. If it is still OFFLINE on STATUS, "
    "switch the robot off and on."
)
RESTART_ROBOT = Message("Switch the robot off and on. If it happens again, keep the log.")
SET_CLOCK = Message("Set the clock of the robot's computer.")
OTHER_SURVEY = Message("End the other survey first: wait for its end, or press STOP.")
END_SERVICE = Message("Wait until the service on this robot has ended, or press STOP.")
CHECK_MARKERS = Message("Look at the markers on MAP, then try again.")
NOTHING_TO_DO = Message("Nothing to do: no survey is in progress.")
NEW_SURVEY = Message("Plan a new survey: this one cannot be continued.")
CORRECT_PLAN = Message("Correct the value in the plan.")
CHECK_CONFIGURATION = Message("Ask the person who maintains the robot to check its configuration.")
CHECK_STATUS = Message("Look on STATUS for the part with a FAULT and touch its line.")


def _rule(words: str, remedy: Message) -> Tuple[Pattern[str], Message]:
    return re.compile(words), remedy


# The first rule that a sentence of the fault fits counts, so special ones come before general ones.
_RULES = (
    _rule(r"AN AXIS IS STILL MOVING|does NOT answer", MOTORS_OFF),
    _rule(r"internal error", RESTART_ROBOT),
    _rule(r"robot is in service", END_SERVICE),
    _rule(r"disk is full|quota|MB are free|make space|must stay free", MAKE_SPACE),
    _rule(
        r"being written by another process|is still open|\{open_survey\}|another survey|"
        r"while a survey|while another one|stop it first|while it is running|is being closed",
        OTHER_SURVEY,
    ),
    _rule(r"clock|would start on", SET_CLOCK),
    _rule(r"markers?\b", CHECK_MARKERS),
    _rule(r"no survey is (running|measuring|paused)", NOTHING_TO_DO),
    _rule(r"points (is|give)|polarizations? (is|are)", CORRECT_PLAN),
    _rule(
        r"start a new (one|survey)|cannot be resumed|cannot resume|survey\.json|in the recordings|"
        r"does not belong to its traces|no survey is open|there is no survey|needs its own id|"
        r"nothing is left to measure|holds survey|not planned|frequencies instead|"
        r"was measured at|other settings of the VNA|is not closed|already stored with|"
        r"damaged|holds trace|no survey can be|cannot become|manifest|\{trace\}|the file |"
        r"an entry of the trace|recorded trace|belongs to survey|already (has index|in \{file)|"
        r"was recorded with|last status|SHA-256",
        NEW_SURVEY,
    ),
    _rule(r"turn the antennas to their mark|has no endstop", SET_ZERO),
    _rule(r"endstop|steps were lost", CHECK_ENDSTOP),
    _rule(r"load|pulse was|real-time", LESS_LOAD),
    _rule(
        r"check that (it|its node|its driver|the simulator) (runs|is running)|stopped answering|"
        r"\{node\}|pulse process|the main control|ROS master|ended by a later one|"
        r"busy with another|shutting down|shut down|pigpio|without a result|"
        r"(survey|request) did not end|no answer within|this happened|"
        r"^stopped answering|is not connected$|the storage did not answer",
        WAIT_FOR_PART,
    ),
    _rule(
        r"_options|\{class_name\}|\{module\}|\{protocol\}|must have the form|scripts/setup\.sh|"
        r"robot's configuration|configuration of this launch|end the launch|"
        r"end every launch|another configuration|is missing; |axis driver first|memory_file|"
        r"SPI bus|step count|library|scikit|parameters of|maker|visa|description of its hardware|"
        r"correction_query|is not configured|namespace|max_coord|simulated one|a real one|"
        r"sensors\.yaml|two sensors|message type|no field|not hold (\{field\}|exactly)",
        CHECK_CONFIGURATION,
    ),
    _rule(r"connect that VNA again|former VNA|which was accepted", SAME_VNA),
    _rule(r"identifies itself|identification", RIGHT_VNA),
    _rule(
        r"not calibrated|calibration status is|lost its calibration|alibrate it|"
        r"report its calibration",
        CALIBRATE,
    ),
    _rule(
        r"could not be (written|stored|made|locked|replaced|repaired|read)|not stored within|"
        r"check the disk|disk (did|was|is|or)|permission denied|not permitted|file of this name|"
        r"this is a (file|folder|symbolic)|not a regular file|moved, removed|no such file|"
        r"folder .* cannot|recordings could|nothing was written|\{path\}|"
        r"folder holds|\{folder\}",
        CHECK_DISK,
    ),
    _rule(r"height|converter|measures from", CHECK_HEIGHT),
    _rule(
        r"not finite|VNA's data|VNA sent|VNA gave|VNA states|VNA answers|VNA reports|"
        r"not a (whole )?number|not understood|imaginary part|number of the trace|"
        r"previous sweep|power-cycle|would not be new|sweep of \{points\}|new average|"
        r"frequency_hz must|values for|contains \{count\}|there are \{points\}|"
        r"lies before|trace is refused|remark|antennae_height|a sweep takes",
        CHECK_VNA,
    ),
    _rule(r"axis is at|the axes (are at|moved)", CHECK_MOTORS),
    _rule(
        r"by hand|VNA mode|did not accept|VNA accepted|instead of|same sweep|no longer those|"
        r"were changed|changed by themselves|cannot set|cannot be confirmed|not confirmed|"
        r"came too late|sweeps by itself|the VNA measures|changed when",
        HANDS_OFF_VNA,
    ),
    _rule(r"VNA|request exceeded|instrument", CHECK_VNA_CABLE),
    _rule(r"\baxis\b|\baxes\b|homing|homed|motion|the move|motor", CHECK_MOTORS),
    _rule(
        r"must (lie|be|differ|have|hold|contain|ascend)|at most|not allowed|no parameters|"
        r"allowed|expected|set both or none|output power|not a time|remove (it|one)|leave it out|"
        r"digits|is missing|nested more|strict JSON|not YAML|larger than|it has \{size|not ASCII|"
        r"metadata_json|settings of the analyzer|holds values",
        CORRECT_PLAN,
    ),
    _rule(r"no answer|closed by the other side|unreachable|connection", CHECK_VNA_CABLE),
)


def find_remedy(fault: Message) -> Optional[Message]:
    """Return what to do first about a fault; None if no sentence of it is known."""
    sentences = [_words(one) for one in fault.nested()]
    # The inner sentences know more than those around them.
    sentences.reverse()
    for pattern, remedy in _RULES:
        if any(pattern.search(words) for words in sentences):
            return remedy
    return None


def _words(message: Message) -> str:
    """Return the English words of a message, without those of the messages in it."""
    # A sentence without a template of its own is text from an earlier version.
    return message.sentence() if message.template == "{text}" else message.template
