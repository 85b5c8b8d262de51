"""The faults that the analysis can report."""

from __future__ import annotations

from functools import partial

from gpr20_common.message import Fault, Message, Severity

_doubt = partial(Fault, severity=Severity.WARNING)
CALIBRATION = _doubt(
    "analysis.calibration",
    Message("Do not rely on levels and depths: measure a known target before you use them."),
)
CLOCK = _doubt("analysis.clock", Message("Use the order of the traces in place of their times."))
DRIFTED = _doubt(
    "analysis.drifted",
    Message("Look at the visits of the first stop in the report before you compare distant rows."),
)
ZEROS_UNPROVEN = _doubt(
    "analysis.zeros_unproven",
    Message(
        "Do not rely on the positions and rotations of these traces: compare the image with the "
        "ground, or measure the area again."
    ),
)
SWEEP_REPEATED = _doubt(
    "analysis.sweep_repeated",
    Message("Do not rely on the ground below these traces: one of two equal ones is a copy."),
)
SETTINGS_CHANGED = _doubt(
    "analysis.settings_changed",
    Message("Look for an edge in the image where the settings changed before you trust it there."),
)
IMPORTED = _doubt(
    "analysis.imported",
    Message("Compare the area with what was to be searched: nothing else says what is missing."),
)
NOT_COMPLETE = _doubt(
    "analysis.survey_not_complete",
    Message(
        "Resume the survey and let it end: where a trace is missing, the ground was not searched."
    ),
)
CHANGED_SINCE_SIGNED = _doubt(
    "analysis.changed_since_signed",
    Message(
        "Ask who added what gpr20 info shows; on the robot, gpr20 sign signs the survey as it is "
        "now."
    ),
)
UNSIGNED = _doubt(
    "analysis.survey_unsigned",
    Message("Ask for the survey as the robot signed it, or verify it without --signers."),
)
UNKNOWN_SIGNER = Fault(
    "analysis.unknown_signer",
    Message(
        "Ask those who maintain the robot for the line of its key, and compare the key's "
        "fingerprint with them. Do not take the line from the survey's sender alone."
    ),
)
WRONG_SIGNATURE = Fault(
    "analysis.wrong_signature",
    Message(
        "Do not use the survey: ask for another copy of it, and compare both. Keep this one as it "
        "is."
    ),
)
FILE_DAMAGED = Fault(
    "analysis.file_damaged",
    Message("Do not use the file. Copy it again from where it was made, or create it again."),
)
NOT_INTACT = Fault(
    "analysis.survey_not_intact",
    Message(
        "Keep the survey's folder as it is, and copy it. Then resume the survey: that checks and "
        "repairs what is stored."
    ),
)
INPUT = Fault(
    "analysis.input",
    Message("Give other data, as the message says; gpr20 info tells what a survey or file holds."),
)
STEPS = Fault(
    "analysis.steps",
    Message(
        "Correct the step or the installed package that the message names. gpr20 "
        "process --help lists the steps."
    ),
)
TOO_LARGE = Fault(
    "analysis.too_large",
    Message(
        "Use a part of the survey, a coarser image or fewer workers, or a computer with more "
        "memory."
    ),
)
NO_ROS = Fault(
    "analysis.no_ros",
    Message("Source catkin_ws/devel/setup.bash and start roscore, then try again."),
)
NO_SCREEN = Fault("analysis.no_screen", Message("Run the command on a computer with a desktop."))
PROGRAM = Fault(
    "analysis.program_error",
    Message("Keep the message and the command, and report them to those who maintain GPR-20."),
)
ROBOT_RUNS = Fault(
    "replay.robot_runs",
    Message("Replay in another namespace, or end the other replay; never end a robot that moves."),
)
PICKS_CHANGED = Fault(
    "viewer.picks_changed", Message("Export the picks now, then open the survey again.")
)
