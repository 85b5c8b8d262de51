"""The faults and errors of the analysis, and the messages that several of them share."""

from __future__ import annotations

from functools import partial
from pathlib import Path, PurePath
from typing import Iterable

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Fault, Message, Severity
from gpr20_survey.faults import DAMAGED

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
NO_INDEX = Fault(
    "analysis.no_index",
    Message(
        "Use the survey's folder, or its survey.mcap. Without them, copy the bag and write the "
        "index of the copy with rosbag reindex."
    ),
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
TOO_FEW_LINES = Fault(
    "analysis.too_few_lines",
    Message("Wait while the survey runs; if it has ended, resume it or measure more lines."),
    Severity.NOTE,
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


class AnalysisError(Gpr20Error):
    """Base of every error of the analysis."""

    fault = NOT_ALLOWED


class UnreadableFileError(AnalysisError, ValueError):
    """A file is damaged or has another content than it should."""

    fault = FILE_DAMAGED


class DamagedSurveyError(AnalysisError, ValueError):
    """Samples of a survey are damaged or missing; the message names them."""

    fault = DAMAGED


class WrongDatasetError(AnalysisError, ValueError):
    """A Dataset does not suit a step, or an option is not allowed."""

    fault = STEPS


class TooLargeError(AnalysisError, MemoryError):
    """The data do not fit into the memory."""

    fault = TOO_LARGE


class ExportError(AnalysisError, ValueError):
    """An output cannot be written, or the format cannot hold the survey."""

    fault = NOT_ALLOWED


class MissingLibraryError(AnalysisError, ImportError):
    """An optional library is not installed."""

    fault = STEPS


class StepError(AnalysisError, ValueError):
    """A chain of steps is malformed, or a step or parameter is unknown."""

    fault = STEPS


def library_missing(library: str, extra: str = "", package: str = "gpr20_analysis") -> Message:
    """Return the message for a library that is not installed.

    Args:
        library: Its name.
        extra: The extra that brings it; empty: the package itself.
        package: The package.
    """
    # A checkout has its own environment, and pip knows none of its packages by name.
    setups = [one / "scripts/setup.sh" for one in Path(__file__).resolve().parents]
    setup = next(filter(Path.is_file, setups), None)
    if setup is not None and not extra:
        return Message("{library} is not installed; run: {command}", library=library, command=setup)
    package = f"{package}[{extra}]" if extra else package
    return Message(
        "{library} is not installed; install it with: pip install '{package}'",
        library=library,
        package=package,
    )


def check_ending(path: PurePath, endings: Iterable[str]) -> None:
    """Check the ending of a path.

    Raises:
        AnalysisError: It has another one; argparse shows its text, but not that of a ValueError.
    """
    if path.suffix not in endings:
        allowed = ", ".join(endings)
        raise AnalysisError(
            Message("{file} must end in {endings}", file=path.name, endings=allowed)
        )


def not_there(path: PurePath) -> Message:
    """Return the message for an input that does not exist."""
    return Message("{path} does not exist", path=path)
