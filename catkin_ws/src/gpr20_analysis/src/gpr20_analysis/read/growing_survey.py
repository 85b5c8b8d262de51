"""A survey that is measured while it is looked at: only its new traces are read."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, Tuple

import xarray as xr

from gpr20_analysis.read.assembly import assemble
from gpr20_analysis.read.sources import open_source, read_trace
from gpr20_survey.trace.trace import Trace

# Further traces are read again each time.
MOST_KEPT_BYTES = 256 << 20

Version = Tuple[int, int]
"""Time of the last change [ns] and length [bytes] of a file."""


class GrowingSurvey:
    """The traces of one survey's folder, kept between two readings."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._kept: Dict[str, Tuple[Version, Trace]] = {}
        self._kept_bytes = 0

    def load(self) -> xr.Dataset:
        """Return what is stored now; damaged samples are left out and marked.

        Returns:
            The Dataset, as `load_survey` returns it.

        Raises:
            AnalysisError: It is no survey, or has no readable trace.
            OSError: It cannot be read.
        """
        return assemble(open_source(self.folder, self._read), accept_damaged=True)

    def _read(self, path: Path) -> Trace:
        status = path.stat()
        version = (status.st_mtime_ns, status.st_size)
        kept = self._kept.get(path.name)
        if kept is not None and kept[0] == version:
            return kept[1]
        trace = read_trace(path)
        if kept is None and self._kept_bytes < MOST_KEPT_BYTES:
            self._kept_bytes += 3 * trace.frequency_hz.nbytes
            self._kept[path.name] = version, trace
        elif kept is not None:
            self._kept[path.name] = version, trace
        return trace
