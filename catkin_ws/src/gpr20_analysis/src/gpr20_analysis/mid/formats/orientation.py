"""How the group names the rotation of the antennas: X and Y for 0 and 90 degrees."""

from __future__ import annotations

from typing import Dict

import numpy as np
import xarray as xr

from gpr20_analysis.errors import ExportError
from gpr20_analysis.mid import dataset

DEGREES: Dict[str, float] = {"X": 0.0, "Y": 90.0}
TOLERANCE_DEG = 1.0  # half a motor step


def letters(survey: xr.Dataset) -> Dict[str, int]:
    """Return the index of the polarization of each letter.

    Raises:
        ExportError: A rotation has no letter.
    """
    found: Dict[str, int] = {}
    for index, rotation_deg in enumerate(survey[dataset.POLARIZATION].values):
        letter = next(
            (one for one, own in DEGREES.items() if abs(rotation_deg - own) <= TOLERANCE_DEG), None
        )
        if letter is None or letter in found:
            raise ExportError(
                f"the antennas' rotations are {survey[dataset.POLARIZATION].values.tolist()} deg; "
                "this format knows 0 (X) and 90 (Y) only: select those two"
            )
        found[letter] = index
    return found


def even_step(values: np.ndarray, name: str, unit: str) -> float:
    """Return the spacing of coordinates that must be evenly spaced; 0 for a single one.

    Raises:
        ExportError: They are not.
    """
    if len(values) < 2:
        return 0.0
    steps = np.diff(values)
    if np.ptp(steps) > 0.01 * abs(steps.mean()):
        raise ExportError(
            f"the spacing of {name} is {steps.min():g} to {steps.max():g} {unit}; this format "
            "holds even spacing only"
        )
    return float((values[-1] - values[0]) / (len(values) - 1))
