"""The file that gprMax's outputfiles_merge makes of many A-scans: no sources and no places.

Its fields have the shape (time, trace). Version 4 keeps the steps of the receiver from trace to
trace, `rxsteps`, in cells of `dx_dy_dz`; version 3 keeps none.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from gpr20_analysis import dataset, faults, lazy
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.message import Message
from gpr20_foreign_formats.gprmax_source import Signal
from gpr20_foreign_formats.header import BYTES_PER_SAMPLE, Header
from gpr20_foreign_formats.traces import needs_spacing

ROTATION_DEG: Dict[str, float] = {"Ex": 0.0, "Ey": 90.0}
MERGED = Message(
    "a merged file of gprMax holds no places: positions begin at 0, and are those of the receiver"
)
Position = Tuple[float, float, float]


def merged_fields(
    file: Any, path: Path, spacing_m: Optional[float]
) -> List[Tuple[Position, Signal]]:
    """Return rotation [deg], y and x [mm], and the strongest horizontal field, of each trace.

    Without a spacing along X [m], the steps are those of the receiver.

    Raises:
        AnalysisError: The steps are neither recorded nor given.
        UnreadableFileError: Fields are missing, zero, or of another shape.
    """
    receivers, count = int(file.attrs.get("nrx", 1)), int(file.attrs["Iterations"])
    fields = {one: file["rxs/rx1"][one] for one in ROTATION_DEG if one in file["rxs/rx1"]}
    shapes = {field.shape for field in fields.values()}
    shape: Tuple[int, ...] = shapes.pop() if len(shapes) == 1 else ()
    if receivers != 1 or len(shape) != 2 or shape[0] != count or not shape[1]:
        text = Message(
            "{file} has no source, as a merged file of gprMax, but {receivers} receivers and "
            "fields of {shape} values; it must have one receiver, and {count} values of each trace",
            file=path.name,
            receivers=receivers,
            shape=" x ".join(map(str, shape)) or "-",
            count=count,
        )
        raise UnreadableFileError(text, fault=faults.INPUT)
    # With Python's integers, which do not overflow.
    size = BYTES_PER_SAMPLE * int(shape[0]) * int(shape[1]) * len(fields)
    lazy.require_bytes(size, Message("reading {file}", file=path.name))
    values = {one: np.asarray(field[()], np.float64) for one, field in fields.items()}
    strongest = {one: float(np.abs(field).max()) for one, field in values.items()}
    along = max(strongest, key=lambda one: strongest[one])
    # A sum, since NaN is no maximum.
    if not 0.0 < sum(strongest.values()) < np.inf:
        raise UnreadableFileError(
            Message("{file}: the fields along X and Y are zero or contain NaN", file=path.name),
            fault=faults.INPUT,
        )
    step_s = time_step_s(file, path.name)
    places_mm = np.arange(shape[1])[:, np.newaxis] * _step_mm(file, path, spacing_m, shape[1])
    return [
        ((ROTATION_DEG[along], float(y_mm), float(x_mm)), Signal(field, step_s))
        for (x_mm, y_mm), field in zip(np.round(places_mm, 6), values[along].T)
    ]


def time_step_s(file: Any, name: str) -> float:
    """Return the time step of a file of this name [s].

    Raises:
        UnreadableFileError: It is none.
    """
    return Header(name, file.attrs).number("dt", 1e-16, 1e-9)


def _step_mm(file: Any, path: Path, spacing_m: Optional[float], count: int) -> np.ndarray:
    """Return the step from trace to trace along X and Y [mm]."""
    if spacing_m is not None:
        return np.array([spacing_m, 0.0]) * dataset.MM_PER_M
    steps, cell_m = (
        np.asarray(file.attrs.get(one, np.zeros(3)), np.float64) for one in ("rxsteps", "dx_dy_dz")
    )
    found: np.ndarray = (steps * cell_m)[:2] * dataset.MM_PER_M
    if not (np.isfinite(found).all() and (found.any() or count == 1)):
        raise needs_spacing(path, Message("the steps of the receiver are not recorded"))
    return found
