"""What the analysis refuses."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class AnalysisError(Gpr20Error):
    """Base of every error of the analysis."""


class UnreadableFileError(AnalysisError, ValueError):
    """A file is not as the storage wrote it."""


class DamagedSurveyError(AnalysisError, ValueError):
    """Samples of a survey cannot be trusted; the faults are named."""


class WrongDatasetError(AnalysisError, ValueError):
    """A Dataset lacks what a step needs, or holds what it cannot work on."""


class TooLargeError(AnalysisError, MemoryError):
    """What must be in memory at once does not fit into it."""


class ExportError(AnalysisError, ValueError):
    """A survey cannot be written in the format that was asked for."""


class MissingLibraryError(AnalysisError, ImportError):
    """An optional library is not installed."""


class RecipeError(AnalysisError, ValueError):
    """A chain of steps is not written as it must be, or names what is not there."""
