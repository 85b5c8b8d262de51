"""The errors of the analysis, and the messages that several of them share."""

from __future__ import annotations

from pathlib import Path, PurePath
from typing import Iterable

from gpr20_analysis import faults
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.faults import DAMAGED


class AnalysisError(Gpr20Error):
    """Base of every error of the analysis."""

    fault = NOT_ALLOWED


class UnreadableFileError(AnalysisError, ValueError):
    """A file is damaged or has another content than it should."""

    fault = faults.FILE_DAMAGED


class DamagedSurveyError(AnalysisError, ValueError):
    """Samples of a survey are damaged or missing; the message names them."""

    fault = DAMAGED


class WrongDatasetError(AnalysisError, ValueError):
    """A Dataset does not suit a step, or an option is not allowed."""

    fault = faults.STEPS


class TooLargeError(AnalysisError, MemoryError):
    """The data do not fit into the memory."""

    fault = faults.TOO_LARGE


class ExportError(AnalysisError, ValueError):
    """An output cannot be written, or the format cannot hold the survey."""

    fault = NOT_ALLOWED


class MissingLibraryError(AnalysisError, ImportError):
    """An optional library is not installed."""

    fault = faults.STEPS


class StepError(AnalysisError, ValueError):
    """A chain of steps is malformed, or a step or parameter is unknown."""

    fault = faults.STEPS


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
