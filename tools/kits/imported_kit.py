"""Random data of other instruments, and the folders of surveys into which they were imported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from hypothesis import strategies as st

from gpr20_analysis.formats.common import as_dataset
from gpr20_analysis.formats.imported_folder import ImportSource, write_imported_folder
from gpr20_common.message import Message
from gpr20_survey.files.file_sums import sum_of

SOURCE = ImportSource("line 7.dzt", "dzt", {"line 7.dzt": sum_of(b"the file")})
NOTE = Message("the record was {length} long", length="8 ns")


@st.composite
def axes_m(draw: Any, most: int = 4) -> np.ndarray:
    """Positions along an axis, ascending, even or not [m]."""
    gaps_mm = draw(st.lists(st.floats(0.5, 500.0), max_size=most - 1))
    start_mm = draw(st.floats(-900.0, 900.0))
    return np.cumsum([start_mm, *gaps_mm]) / 1000.0


@st.composite
def imported_surveys(draw: Any) -> xr.Dataset:
    """Small surveys, lines and single stops too, with missing samples, heights and times."""
    turns_deg = draw(st.sampled_from([[0.0], [90.0], [0.0, 90.0], [-45.0, 0.0, 45.0]]))
    y_m, x_m = draw(axes_m()), draw(axes_m())
    shape = (len(turns_deg), len(y_m), len(x_m))
    random = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    points = draw(st.integers(2, 9))
    parts = random.standard_normal((2, *shape, points)) * 10.0 ** random.uniform(-9, 3)
    s21 = parts[0] + 1j * parts[1]
    missing = random.random(shape) < draw(st.sampled_from([0.0, 0.3]))
    missing.flat[random.integers(missing.size)] = False
    s21[missing] = np.nan
    height_m = random.uniform(0.0, 0.5, shape)
    height_m[random.random(shape) < 0.2] = np.nan
    height_m[missing] = np.nan
    survey = as_dataset(
        s21, turns_deg, y_m, x_m, height_m, SOURCE.name,
        frequency_hz=np.cumsum(random.uniform(1e6, 1e9, points)),
        simulated=draw(st.sampled_from([None, False, True])),
        notes=[NOTE],
    )  # fmt: skip
    if draw(st.booleans()):
        times_us = 1_600_000_000_000_000 + random.integers(0, 10**9, shape)
        times = np.where(missing, np.datetime64("NaT", "us"), times_us.astype("datetime64[us]"))
        survey["timestamp"] = (survey["timestamp"].dims, times.astype("datetime64[ns]"))
    return survey.assign_attrs(site="Facatativá", antenna_delay_s=1.5e-9, processing="[]")


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
