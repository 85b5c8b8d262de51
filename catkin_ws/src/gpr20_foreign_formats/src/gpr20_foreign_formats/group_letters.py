"""The letters of the group for the rotations of the antennas."""

from __future__ import annotations

from typing import Dict

import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import ExportError
from gpr20_common.message import Message

DEGREES: Dict[str, float] = {"X": 0.0, "Y": 90.0}
TOLERANCE_DEG = 1.0  # half a motor step
DECIDED = Message(
    "the letters X and Y are rotations of 0 and 90 deg; the files do not name the direction of the "
    "rotation"
)
"""What the importers of these files decide."""
PHASE_DECIDED = Message(
    "the phase of a later echo falls faster with frequency, as a VNA measures it; no sign was "
    "changed"
)
"""What the importers of spectra decide."""


def letters(survey: xr.Dataset) -> Dict[str, int]:
    """Return the index of the polarization of each letter, X or Y.

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
                Message(
                    "the rotations of the antennas are {rotations} deg; this format supports only "
                    "0 (X) and 90 (Y); select these with the step polarization",
                    rotations=", ".join(f"{one:g}" for one in survey[dataset.POLARIZATION].values),
                ),
                fault=faults.FORMAT,
            )
        found[letter] = index
    return found
