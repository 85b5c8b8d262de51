"""What a list of surveys says about one of them: in words, and as a map of what is stored."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ProcessingError, storing
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_record import UNCONFIRMED
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.recovery import read_description, unconfirmed_message
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.recorded_plan import import_sentence, is_imported, measured_area, refines_of
from gpr20_survey.plan.survey_state import reported_verdict
from gpr20_survey.results.answers import SurveySummary

MOST_CELLS = 24
MOST_PLANNED = 1 << 24
LARGEST_MM = 1e6
TRACE_FILE = re.compile(r"([0-9]{6})_X[-0-9.]+_Y[-0-9.]+_Z[-+0-9.]+\.json")


def summary_of(folder: Path) -> SurveySummary:
    """Return the summary of a survey; what is not as it should be is its problem, or left out."""
    try:
        survey_folder.check_no_links(folder)
        values = read_description(folder)
        stored = list(trace_names(folder))
        # Without a manifest nothing vouches for the outcome.
        sealed = (folder / MANIFEST_FILE).is_file()
    except ProcessingError as error:
        return SurveySummary(folder.name, problem=error.message)
    area, imported = measured_area(values), is_imported(values)
    counts = None if imported else _counts_of(area)
    planned = math.prod(counts) if counts else 0
    outcome = _text(values.get("outcome"))
    # The report of a survey that was cut off may be older than its last traces.
    cut_off = outcome in ("", survey_metadata.INTERRUPTED)
    verdict = None if cut_off else reported_verdict(values.get("report"))
    sentence = None if verdict is None else verdict.message
    if imported:
        sentence = import_sentence(values)
    unconfirmed = values.get(UNCONFIRMED)
    if unconfirmed:
        sentence = unconfirmed_message(unconfirmed)
    annotation = values.get(ANNOTATION)
    written: Dict[str, Any] = annotation if isinstance(annotation, dict) else {}
    return SurveySummary(
        folder=folder.name,
        survey_id=values["survey_id"],
        started=_text(values.get("started")),
        outcome=outcome,
        stored_traces=len(stored),
        planned_traces=planned,
        verdict=sentence,
        complete=sealed
        and not unconfirmed
        and outcome == "finished"
        and 0 < planned == len(stored),
        # Data of unknown origin are never shown as those of real ground.
        simulated=values.get("simulated") is not False,
        refines=refines_of(values),
        name=_text(written.get("name")),
        site=_text(written.get("site")),
        operator=_text(written.get("operator")),
        **map_of(area, stored),
    )


def trace_names(folder: Path) -> Dict[int, str]:
    """Return the name of the JSON file of each stored trace by its index, ascending.

    Raises:
        StorageFailedError: The survey's folder cannot be read.
    """
    found: Dict[int, str] = {}
    failure = Message("the traces in {folder} cannot be read", folder=printable(folder))
    with storing(failure, folder):
        for entry in os.scandir(str(folder / survey_folder.TRACES_FOLDER)):
            match = TRACE_FILE.fullmatch(entry.name)
            if match and entry.is_file(follow_symlinks=False):
                found[int(match.group(1))] = entry.name
    return dict(sorted(found.items()))


def map_of(area: Any, stored: Sequence[int]) -> Dict[str, Any]:
    """Return the size of a survey and the map of its stored traces, as fields of its summary."""
    if not isinstance(area, Mapping):
        return {}
    ends: List[Any] = [area.get(f"{one}_{end}_mm") for one in "xy" for end in ("start", "stop")]
    # Compared before it is converted: a whole number of JSON may have hundreds of digits.
    if not all(type(one) in (int, float) and abs(one) <= LARGEST_MM for one in ends):
        return {}
    x_start_mm, x_stop_mm, y_start_mm, y_stop_mm = ends
    size = {"width_mm": abs(x_stop_mm - x_start_mm), "height_mm": abs(y_stop_mm - y_start_mm)}
    counts = _counts_of(area)
    if counts is None:
        return size
    x_points, y_points, turns = counts
    indices = np.asarray([one for one in stored if one < math.prod(counts)], np.int64)
    row, column = np.divmod(indices // turns, x_points)
    # Every second row is measured in the other direction.
    backwards = (row % 2 == 1) != (x_start_mm > x_stop_mm)
    column = np.where(backwards, x_points - 1 - column, column)
    if y_start_mm > y_stop_mm:
        row = y_points - 1 - row
    columns, rows = min(x_points, MOST_CELLS), min(y_points, MOST_CELLS)
    found = np.zeros((rows, columns), np.int64)
    np.add.at(found, (row * rows // y_points, column * columns // x_points), 1)
    planned = np.outer(_share(y_points, rows), _share(x_points, columns)) * turns
    percent = np.clip(found * 100 // planned, (found > 0).astype(np.int64), 100)
    map_percent = percent.astype(np.uint8).tobytes()
    return {**size, "map_columns": columns, "map_rows": rows, "map_percent": map_percent}


def _counts_of(area: Any) -> Optional[Tuple[int, int, int]]:
    """Return how many columns, rows and rotations parameters have; None if they are unreadable."""
    if not isinstance(area, Mapping):
        return None
    rotations = area.get("polarizations_deg")
    turns = len(rotations) if isinstance(rotations, list) else 0
    counts: Any = (area.get("x_points"), area.get("y_points"), turns)
    is_plan = all(type(one) is int and one > 0 for one in counts)
    return counts if is_plan and math.prod(counts) <= MOST_PLANNED else None


def _share(points: int, cells: int) -> np.ndarray:
    """Return how many of the points belong to each cell."""
    return np.bincount(np.arange(points) * cells // points, minlength=cells)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        return ""
    # Half of a character, which JSON can hold, cannot be sent: no survey would be listed.
    return value.encode("utf-8", "backslashreplace").decode("utf-8")
