"""What the analysis refuses."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class AnalysisError(Gpr20Error):
    """Base of every error of the analysis."""


class UnreadableFileError(AnalysisError, ValueError):
    """A file is not as the storage wrote it."""
