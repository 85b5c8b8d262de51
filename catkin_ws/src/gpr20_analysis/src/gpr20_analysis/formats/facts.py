"""What a file of another format must keep of a survey besides its numbers.

Most formats have no place for it: it is then in the file NAME.json beside the export NAME. What
must never be lost, that data are simulated, is also in the names or contents of the files.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import UnreadableFileError
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
from gpr20_common.message import Message, verbatim

SIMULATED = "SIMULATED"
"""Word in names, titles and comments of files whose data are simulated."""
TEXTS = (
    "survey_id",
    survey_attributes.NAME,
    survey_attributes.OPERATOR,
    survey_attributes.SITE,
    survey_attributes.NOTES,
    survey_attributes.OUTPUT_POWER,
    "processing",
    dataset.DISPLAY_ONLY,
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
        if isinstance(value, (int, float, np.integer, np.floating)) and np.isfinite(value):
            attributes[one] = float(value)
    if isinstance(values.get(SIMULATED_KEY), (bool, int, np.integer, np.bool_)):
        # What says that it is simulated wins over what says that it is not.
        attributes[SIMULATED_KEY] = int(bool(values[SIMULATED_KEY]) or is_simulated(data))
    return with_doubts(data.assign_attrs(attributes), *carried_doubts(values))


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
        turns, ys, xs = (data[axis].values.astype(float) for axis in dataset.SAMPLE_DIMS)
        ys, xs = ys * dataset.MM_PER_M, xs * dataset.MM_PER_M
        grid = SurveyGrid(*(tuple(axis.tolist()) for axis in (turns, ys, xs)))
        return cls(kept(data), grid, tuple(map(str, sentences_of(data, NOTES))))

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

    def restored(self, data: xr.Dataset) -> xr.Dataset:
        """Return imported data with these facts."""
        present = set(map(str, sentences_of(data, NOTES)))
        more = [verbatim(one) for one in self.notes if one not in present]
        data = restored(data, self.values)
        return data.assign_attrs(with_notes(data, more)) if more else data


def facts_path(export: Path) -> Path:
    """Return the path of the file beside an export."""
    return export.with_name(f"{export.name}.json")


def write_facts(survey: xr.Dataset, path: Path) -> None:
    """Write the facts of an exported survey to a new file.

    Raises:
        OSError: It cannot be written.
    """
    path.write_text(json.dumps(Facts.of(survey).as_json(), indent=1), encoding="utf-8")


def facts_beside(export: Path) -> Optional[Facts]:
    """Return what the file beside an export says of it; None if there is no such file.

    Raises:
        UnreadableFileError: It is not as it was written.
        OSError: It cannot be read.
    """
    path = facts_path(export)
    if not path.is_file():
        return None
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        axes = (found[name] for name in ("polarization_deg", "y_mm", "x_mm"))
        grid = SurveyGrid(*(tuple(map(float, axis)) for axis in axes))
        return Facts(found, grid, [str(one) for one in found[NOTES]])
    except (KeyError, TypeError, ValueError) as error:
        raise UnreadableFileError(
            Message("{file} is damaged; delete it, or export the survey again", file=path.name)
        ) from error


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
