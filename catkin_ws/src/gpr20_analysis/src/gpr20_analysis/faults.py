"""The faults that the analysis can report."""

from __future__ import annotations

from functools import partial

from gpr20_common.message import Fault, Message, Severity

OPTION = Fault(
    "analysis.option",
    Message("Correct the option or value that the message names, and run the command again."),
)
NO_INPUT = Fault(
    "analysis.no_input",
    Message("Check the path: give the survey's folder, its recording, or files to import."),
)
NO_TRACES = Fault("analysis.no_traces", Message("Resume the survey, or choose another one."))
IMPORT_FIRST = Fault(
    "analysis.import_first", Message("Import the files with gpr20 import, then use the result.")
)
FILE_CONTENT = Fault(
    "analysis.file_content",
    Message("Check how the files were made, and correct what the message names."),
)
FILE_DAMAGED = Fault(
    "analysis.file_damaged",
    Message("Do not use the file. Copy it again from where it was made, or create it again."),
)
FILE_CHANGED = Fault(
    "analysis.file_changed",
    Message("Do not use the files unless you know who changed them: create them again."),
)
RECORDING_DAMAGED = Fault(
    "analysis.recording_damaged",
    Message("Use the survey's folder instead: gpr20 verify says which of its forms is whole."),
)
SURVEY_DAMAGED = Fault(
    "analysis.survey_damaged",
    Message("Keep the survey's folder as it is, and copy it. Then look with gpr20 verify."),
)
# What verify says of a survey, when it has looked.
NOT_INTACT = Fault(
    "analysis.survey_not_intact",
    Message(
        "Keep the survey's folder as it is, and copy it. Then resume the survey: that checks and "
        "repairs what is stored."
    ),
)
IMPORT_NOT_INTACT = Fault(
    "analysis.import_not_intact",
    Message("Import the source again, and use that survey in place of this one."),
)
# Why something of a survey may not be believed: the kinds of its doubts.
_doubt = partial(Fault, severity=Severity.WARNING)
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
CALIBRATION = _doubt(
    "analysis.calibration",
    Message("Do not rely on levels and depths: measure a known target before you use them."),
)
DRIFTED = _doubt(
    "analysis.drifted",
    Message("Look at the visits of the first stop in the report before you compare distant rows."),
)
SETTINGS_CHANGED = _doubt(
    "analysis.settings_changed",
    Message("Look for an edge in the image where the settings changed before you trust it there."),
)
CLOCK = _doubt("analysis.clock", Message("Use the order of the traces in place of their times."))
IMPORTED = _doubt(
    "analysis.imported",
    Message("Compare the area with what was to be searched: nothing else says what is missing."),
)
NOT_COMPLETE = Fault(
    "analysis.survey_not_complete",
    Message(
        "Resume the survey and let it end: where a trace is missing, the ground was not searched."
    ),
    Severity.WARNING,
)
MANIFEST = Fault(
    "analysis.manifest",
    Message("Run gpr20 repair: it writes the manifest again if everything else agrees."),
)
WRONG_SIGNATURE = Fault(
    "analysis.wrong_signature",
    Message(
        "Do not use the survey: ask for another copy of it, and compare both. Keep this one as it "
        "is."
    ),
)
UNKNOWN_SIGNER = Fault(
    "analysis.unknown_signer",
    Message(
        "Ask those who maintain the robot for the line of its key, and compare the key's "
        "fingerprint with them. Do not take the line from the survey's sender alone."
    ),
)
CHANGED_SINCE_SIGNED = Fault(
    "analysis.changed_since_signed",
    Message(
        "Ask who added what gpr20 info shows; on the robot, gpr20 sign signs the survey as it is "
        "now."
    ),
    Severity.WARNING,
)
UNSIGNED = Fault(
    "analysis.survey_unsigned",
    Message("Ask for the survey as the robot signed it, or verify it without --signers."),
    Severity.WARNING,
)
FILES_DIFFER = Fault(
    "analysis.files_differ",
    Message("Keep a copy of the survey's folder, then resume the survey: that repairs its files."),
)
SIGNERS_FILE = Fault(
    "analysis.signers_file",
    Message("Check the path of the signers file: one line for each robot whose key you accept."),
)
NOT_CLOSED = Fault(
    "analysis.survey_not_closed",
    Message("Resume the survey and let it end, or stop it: that writes the manifest."),
)
SAMPLES_MISSING = Fault(
    "analysis.samples_missing",
    Message("Resume the survey to measure what is missing, or choose how to do without."),
)
NO_HEIGHT = Fault(
    "analysis.no_height", Message("Give one antenna height with --height, or apply the step fill.")
)
NO_GRID = Fault(
    "analysis.no_grid", Message("Give the survey's folder: its log describes the grid.")
)
STEPS = Fault("analysis.steps", Message("Check the steps that were applied, and their order."))
METHOD = Fault(
    "analysis.method",
    Message("Choose another method: --method back-projection has the fewest conditions."),
)
BAND_TOO_NARROW = Fault(
    "analysis.band_too_narrow", Message("Use more of the band, or measure with a wider one.")
)
SWEEP = Fault(
    "analysis.sweep",
    Message("Use data of a sweep with two or more frequencies at equal steps."),
)
REFERENCE = Fault(
    "analysis.reference",
    Message("Measure a reference towards the sky, with the sweep and rotations of the survey."),
)
NO_SAMPLES = Fault(
    "analysis.no_samples",
    Message("Measure more points, or look with gpr20 info and check the steps."),
)
TOO_DEEP = Fault(
    "analysis.too_deep", Message("Choose a smaller depth, or measure with more frequencies.")
)
TOO_FEW_LINES = Fault(
    "analysis.too_few_lines",
    Message(
        "Wait until the survey has measured more lines. Image a single line with gpr20 candidates."
    ),
    Severity.NOTE,
)
NO_SURFACE_ECHO = Fault(
    "analysis.no_surface_echo",
    Message(
        "Give the delay of cables and antennas with --delay; it is measured over a metal plate."
    ),
)
PLATE = Fault(
    "analysis.plate",
    Message(
        "Measure the metal plate at four or more heights, as the guide to calibration says, and "
        "run gpr20 antenna again."
    ),
)
NO_PERMITTIVITY = Fault(
    "analysis.no_permittivity",
    Message("Give the permittivity of the ground: measure it, or take that of similar ground."),
)
TOO_LARGE = Fault(
    "analysis.too_large",
    Message("Use a part of the survey or a coarser image, or a computer with more memory."),
)
DISK = Fault(
    "analysis.disk",
    Message("Check the file that the message names, its disk, and that you may read and write it."),
)
OUTPUT = Fault("analysis.output", Message("Choose another place or name for the output."))
FORMAT = Fault(
    "analysis.format",
    Message("Choose a format that can hold the data, or change the data as the message says."),
)
NO_POSITION = Fault(
    "analysis.no_position",
    Message("Set the survey's position with gpr20 annotate, or choose another format."),
)
LIBRARY = Fault("analysis.library_missing", Message("Install the library that the message names."))
NO_WORKSPACE = Fault(
    "analysis.no_workspace", Message("Source catkin_ws/devel/setup.bash, then try again.")
)
NO_ROS_MASTER = Fault("analysis.no_ros_master", Message("Start roscore, then try again."))
ROBOT_RUNS = Fault(
    "replay.robot_runs",
    Message("End the other replay or the robot, or replay in another namespace."),
)
CLUSTER = Fault(
    "analysis.cluster",
    Message("Start the dask scheduler and its workers, or leave --scheduler out."),
)
WORKER_KILLED = Fault(
    "analysis.worker_killed",
    Message("Run the same command again with fewer workers, or where there is more memory."),
)
SURVEY_RUNS = Fault(
    "analysis.survey_runs", Message("End the survey on the robot first, or use its window.")
)
RECIPE = Fault(
    "analysis.recipe",
    Message("Correct the step or recipe; gpr20 process --help lists steps and parameters."),
)
STEP_VERSION = Fault(
    "analysis.step_version", Message("Install the version of the step that the message names.")
)
OWN_STEP = Fault(
    "analysis.own_step",
    Message("Correct the program of the step that the message names, or leave the step out."),
)
# Commands were the first that packages could add.
ADDITION = Fault(
    "analysis.own_command",
    Message("Correct or remove the installed package that the message names."),
)
INTERRUPTED = Fault(
    "analysis.interrupted",
    Message("Nothing to do: run the command again when you want its result."),
    Severity.NOTE,
)
PROGRAM = Fault(
    "analysis.program_error",
    Message("Keep the message and the command, and report them to those who maintain GPR-20."),
)
