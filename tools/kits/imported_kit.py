"""Lines of other instruments, and the folders of surveys into which they were imported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from gpr20_analysis.formats.common import as_dataset
from gpr20_analysis.formats.imported_folder import ImportSource, write_imported_folder
from gpr20_survey.files.regular_files import sum_of

SOURCE = ImportSource("line 7.dzt", "dzt", {"line 7.dzt": sum_of(b"the file")})


def line_survey(count: int = 5, rows: int = 1) -> xr.Dataset:
    """Return an even line, or some lines beside each other."""
    shape = (1, rows, count, 8)
    parts = np.random.default_rng(7).standard_normal((2, *shape))
    return as_dataset(
        parts[0] + 1j * parts[1], [0.0], np.arange(rows) * 0.1, np.arange(count) * 0.02,
        np.full(shape[:3], 0.01), SOURCE.name, frequency_hz=np.linspace(1e9, 3e9, 8),
        simulated=False,
    )  # fmt: skip


def imported_folder(data: Path, count: int = 5, rows: int = 1) -> Path:
    """Return the folder of a survey that was imported into a folder of surveys."""
    return write_imported_folder(line_survey(count, rows), data, SOURCE)
