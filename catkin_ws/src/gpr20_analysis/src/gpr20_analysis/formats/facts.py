"""What a file of another format must keep of a survey besides its numbers.

Most formats have no place for it: it is then in the file NAME.json beside the export NAME. What
must never be lost, that data are simulated, is also in the names or contents of the files.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, Mapping

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.read import survey_attributes
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
GRID = ("polarization_deg", "y_mm", "x_mm")
"""Coordinates of all samples, missing ones included."""


def is_simulated(data: xr.Dataset) -> bool:
    """Return whether the data are known to be simulated."""
    return bool(data.attrs.get(SIMULATED_KEY))


def marked(text: str, data: xr.Dataset) -> str:
    """Return a title that says so if the data are simulated."""
    return f"{text} ({SIMULATED})" if is_simulated(data) and SIMULATED not in text else text


def facts_of(data: xr.Dataset) -> Dict[str, Any]:
    """Return attributes, grid and notes, which every format keeps, as values of JSON."""
    found: Dict[str, Any] = {one: str(data.attrs[one]) for one in TEXTS if one in data.attrs}
    found.update({one: float(data.attrs[one]) for one in NUMBERS if one in data.attrs})
    if SIMULATED_KEY in data.attrs:
        found[SIMULATED_KEY] = is_simulated(data)
    doubts = kept_doubts(sentences_of(data, DOUBTS))
    if doubts:
        found[DOUBTS] = "\n".join(doubts)
    for name, axis in zip(GRID, dataset.SAMPLE_DIMS):
        scale = 1.0 if axis == dataset.POLARIZATION else dataset.MM_PER_M
        found[name] = (data[axis].values.astype(float) * scale).tolist()
    return {**found, NOTES: list(map(str, sentences_of(data, NOTES)))}


def attributes_of(facts: Mapping[str, Any]) -> Dict[str, Any]:
    """Return the attributes in facts, also of a hand-made file; those of a wrong type are none."""
    found: Dict[str, Any] = {one: facts[one] for one in TEXTS if isinstance(facts.get(one), str)}
    for one in NUMBERS:
        value = facts.get(one)
        if isinstance(value, (int, float, np.integer, np.floating)) and np.isfinite(value):
            found[one] = float(value)
    if isinstance(facts.get(SIMULATED_KEY), (bool, int, np.integer, np.bool_)):
        found[SIMULATED_KEY] = int(bool(facts[SIMULATED_KEY]))
    return found


def with_facts(data: xr.Dataset, facts: Mapping[str, Any]) -> xr.Dataset:
    """Return imported data with what is known of the survey besides."""
    found = attributes_of(facts)
    if is_simulated(data):
        found.pop(SIMULATED_KEY, None)  # what says that they are simulated wins
    data = with_doubts(data.assign_attrs(found), *carried_doubts(facts))
    present = set(map(str, sentences_of(data, NOTES)))
    more = [verbatim(str(one)) for one in facts.get(NOTES, ()) if str(one) not in present]
    return data.assign_attrs(with_notes(data, more)) if more else data


def facts_path(export: Path) -> Path:
    """Return the path of the file beside an export."""
    return export.with_name(f"{export.name}.json")


def write_facts(survey: xr.Dataset, path: Path) -> None:
    """Write the facts of an exported survey to a new file.

    Raises:
        OSError: It cannot be written.
    """
    path.write_text(json.dumps(facts_of(survey), indent=1), encoding="utf-8")


def facts_beside(export: Path) -> Dict[str, Any]:
    """Return what the file beside an export says of it; nothing if there is no such file.

    Raises:
        UnreadableFileError: It is not as it was written.
        OSError: It cannot be read.
    """
    path = facts_path(export)
    if not path.is_file():
        return {}
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        axes = {name: list(map(float, found[name])) for name in GRID}
        return {**found, **axes, NOTES: list(found[NOTES])}
    except (KeyError, TypeError, ValueError) as error:
        raise UnreadableFileError(
            Message("{file} is damaged; delete it, or export the survey again", file=path.name)
        ) from error
