"""What a file of another format must keep of a survey besides its numbers.

Most formats have no place for it: it is then in the file of checksums beside the export, and what
must never be lost, that data are simulated, is also in the names or contents of the files.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.processing.display import DISPLAY_ONLY
from gpr20_analysis.processing.to_frequency import SPECTRUM
from gpr20_analysis.read import survey_attributes
from gpr20_analysis.read.survey_grid import SurveyGrid
from gpr20_analysis.sentences import (
    DOUBTS,
    NOTES,
    carried_doubts,
    kept_doubts,
    sentences_of,
    with_doubts,
    with_notes,
)
from gpr20_common.message import verbatim

SIMULATED = "SIMULATED"
"""Word in names, titles and comments of files whose data are simulated."""
TEXTS = (
    "survey_id",
    survey_attributes.NAME,
    survey_attributes.OPERATOR,
    survey_attributes.SITE,
    survey_attributes.NOTES,
    survey_attributes.OUTPUT_POWER,
    SPECTRUM,
    "processing",
    DISPLAY_ONLY,
)
NUMBERS = (
    survey_attributes.LATITUDE,
    survey_attributes.LONGITUDE,
    survey_attributes.IF_BANDWIDTH,
    survey_attributes.AVERAGES,
    survey_attributes.ANTENNA_DELAY,
    survey_attributes.ANTENNA_SEPARATION,
)
SIMULATED_KEY = "simulated"
ROUNDED_MM = 0.051  # SEG-Y holds tenths of a millimetre


def is_simulated(data: xr.Dataset) -> bool:
    """Return whether the data are known to be simulated."""
    return bool(data.attrs.get(SIMULATED_KEY))


def marked(text: str, data: xr.Dataset) -> str:
    """Return a title that says so if the data are simulated."""
    return f"{text} ({SIMULATED})" if is_simulated(data) and SIMULATED not in text else text


def kept(data: xr.Dataset) -> Dict[str, Any]:
    """Return the attributes that every format keeps, as values of JSON."""
    found: Dict[str, Any] = {one: str(data.attrs[one]) for one in TEXTS if one in data.attrs}
    found.update({one: float(data.attrs[one]) for one in NUMBERS if one in data.attrs})
    if SIMULATED_KEY in data.attrs:
        found[SIMULATED_KEY] = is_simulated(data)
    doubts = kept_doubts(sentences_of(data, DOUBTS))
    return {**found, DOUBTS: "\n".join(doubts)} if doubts else found


def restored(data: xr.Dataset, values: Mapping[str, Any]) -> xr.Dataset:
    """Return a Dataset with attributes that a file has kept; those of a wrong type are ignored."""
    attributes = dict(data.attrs)
    attributes.update({one: values[one] for one in TEXTS if isinstance(values.get(one), str)})
    for one in NUMBERS:
        value = values.get(one)
        if _is_number(value):
            attributes[one] = float(value)  # type: ignore[arg-type]
    if isinstance(values.get(SIMULATED_KEY), (bool, int, np.integer, np.bool_)):
        # What says that it is simulated wins over what says that it is not.
        attributes[SIMULATED_KEY] = int(bool(values[SIMULATED_KEY]) or is_simulated(data))
    return with_doubts(data.assign_attrs(attributes), *carried_doubts(values))


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and bool(np.isfinite(value))


@dataclass(frozen=True)
class Facts:
    """What the file beside an export says of it.

    Attributes:
        values: Attributes, see `kept`.
        grid: Coordinates of all samples, missing ones included; None if unknown.
        notes: Notes of the survey, in English.
    """

    values: Mapping[str, Any]
    grid: Optional[SurveyGrid] = None
    notes: Sequence[str] = ()

    @classmethod
    def of(cls, data: xr.Dataset) -> Facts:
        """Return those of a survey."""
        turns, ys, xs = (
            tuple(float(one) for one in data[axis].values) for axis in dataset.SAMPLE_DIMS
        )
        ys, xs = (tuple(one * dataset.MM_PER_M for one in axis) for axis in (ys, xs))
        return cls(
            kept(data), SurveyGrid(turns, ys, xs), tuple(map(str, sentences_of(data, NOTES)))
        )

    def as_json(self) -> Dict[str, Any]:
        """Return them as values of JSON."""
        found = {**self.values, NOTES: list(self.notes)}
        if self.grid is not None:
            found.update(
                polarization_deg=list(self.grid.polarization_deg),
                y_mm=list(self.grid.y_mm),
                x_mm=list(self.grid.x_mm),
            )
        return found

    @classmethod
    def from_json(cls, found: Mapping[str, Any]) -> Facts:
        """Return the facts that `as_json` gave.

        Raises:
            KeyError, TypeError, ValueError: They are malformed.
        """
        axes = [
            tuple(float(one) for one in found[name])
            for name in ("polarization_deg", "y_mm", "x_mm")
        ]
        return cls(found, SurveyGrid(*axes), [str(one) for one in found[NOTES]])

    def restored(self, data: xr.Dataset) -> xr.Dataset:
        """Return imported data with these facts."""
        present = set(map(str, sentences_of(data, NOTES)))
        more = [verbatim(one) for one in self.notes if one not in present]
        data = restored(data, self.values)
        return data.assign_attrs(with_notes(data, more)) if more else data


def snapped(positions: np.ndarray, grid: Optional[SurveyGrid]) -> Optional[np.ndarray]:
    """Return positions moved to the coordinates of a grid; None if they are not on it.

    Args:
        positions: (samples, 3), rotation [deg], y and x [mm], rounded as files do.
        grid: The grid, or None.
    """
    if grid is None:
        return None
    columns: List[np.ndarray] = []
    for column, (axis, tolerance) in enumerate(
        ((grid.polarization_deg, 1.0), (grid.y_mm, ROUNDED_MM), (grid.x_mm, ROUNDED_MM))
    ):
        own = np.asarray(axis)
        nearest = np.abs(positions[:, column, None] - own[None, :]).argmin(axis=1)
        if np.any(np.abs(own[nearest] - positions[:, column]) > tolerance):
            return None
        columns.append(own[nearest])
    return np.stack(columns, axis=1)
