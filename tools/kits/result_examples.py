"""Examples of what is made of measurements: imported lines, and maps of hidden targets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from gpr20_analysis.formats.common import as_dataset
from gpr20_analysis.formats.imported_folder import ImportSource, write_imported_folder
from gpr20_survey.files.regular_files import sum_of
from gpr20_survey.results.hiding_map import HidingMap, Targets

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


def a_map(found: Any, tried: Any, needed: float = 0.8, **changes: Any) -> HidingMap:
    """Return a map of places 100 mm apart and depths 20 mm apart.

    Args:
        found: How many targets were found (depth, y, x).
        tried: How many were tried.
        needed: Share that must be found.
        **changes: Other values of the map.
    """
    found, tried = np.asarray(found), np.asarray(tried)
    layers, rows, columns = found.shape
    values = {
        "survey_id": "a",
        "simulated": False,
        "target": Targets.PMN.value,
        "x_m": 0.1 * np.arange(columns),
        "y_m": 0.1 * np.arange(rows),
        "depth_m": 0.02 * np.arange(1, layers + 1),
        "tried": tried,
        "found": found,
        "lowest": np.zeros(found.shape),
        "highest": np.ones(found.shape),
        "needed": needed,
        "within_m": np.full(layers, 0.1),
        "permittivity": 5.0,
        "permittivity_range": (4.0, 6.0),
        "loss_tangent": 0.05,
        **{"seed": 0, "position": None},
    }
    return HidingMap(**{**values, **changes})
