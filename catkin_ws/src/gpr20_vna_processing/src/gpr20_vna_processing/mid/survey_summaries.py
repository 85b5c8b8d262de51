"""What a list of surveys says about one of them: in words, and as a map of what is stored."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence

import numpy as np

from gpr20_survey.errors import ProcessingError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_content import UNCONFIRMED
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.recovery import read_description, unconfirmed_message
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.imported import import_sentence, is_imported, measured_area
from gpr20_survey.plan.recorded_plan import refines_of
from gpr20_survey.plan.survey_state import reported_verdict
from gpr20_survey.results.survey_summary import NO_THUMBNAIL, SurveySummary, Thumbnail
from gpr20_vna_processing.mid.stored_files import trace_names

MOST_CELLS = 24
MOST_PLANNED = 1 << 24
LARGEST_MM = 1e6


class _Plan(NamedTuple):
    x_points: int
    y_points: int
    turns: int

    @property
    def traces(self) -> int:
        return self.x_points * self.y_points * self.turns


def summary_of(folder: Path) -> SurveySummary:
    """Return the summary of a survey; what is not as it should be is its problem, or left out."""
    try:
        survey_folder.check_no_links(folder)
        values = read_description(folder)
        survey_folder.check_survey_id(values["survey_id"])
        stored = list(trace_names(folder))
        # Without a manifest nothing vouches for the outcome.
        sealed = (folder / MANIFEST_FILE).is_file()
    except ProcessingError as error:
        return SurveySummary(folder.name, problem=error.message)
    area, imported = measured_area(values), is_imported(values)
    plan = None if imported else _plan_of(area)
    planned = 0 if plan is None else plan.traces
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
        **_people(values.get(ANNOTATION)),
        thumbnail=thumbnail_of(area, stored),
        fault_code=_text(values.get(survey_metadata.FAULT_CODE)),
    )


def thumbnail_of(area: Any, stored: Sequence[int]) -> Thumbnail:
    """Return the thumbnail of a survey; an empty one if its parameters cannot be read.

    Args:
        area: The parameters of its survey.json, as they were read.
        stored: Places in the plan of the stored traces.
    """
    if not isinstance(area, Mapping):
        return NO_THUMBNAIL
    ends: List[Any] = [area.get(f"{one}_{end}_mm") for one in "xy" for end in ("start", "stop")]
    if not all(map(_is_place, ends)):
        return NO_THUMBNAIL
    x_start_mm, x_stop_mm, y_start_mm, y_stop_mm = ends
    size_mm = abs(x_stop_mm - x_start_mm), abs(y_stop_mm - y_start_mm)
    plan = _plan_of(area)
    if plan is None:
        return Thumbnail(*size_mm)
    x_points, y_points, turns = plan
    indices = np.asarray([one for one in stored if one < plan.traces], np.int64)
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
    return Thumbnail(*size_mm, columns, rows, percent.astype(np.uint8).tobytes())


def _plan_of(area: Any) -> Optional[_Plan]:
    """Return how many stops and rotations parameters have; None if they cannot be read."""
    if not isinstance(area, Mapping):
        return None
    rotations = area.get("polarizations_deg")
    turns = len(rotations) if isinstance(rotations, list) else None
    counts = (area.get("x_points"), area.get("y_points"), turns)
    if not all(type(one) is int and 0 < one <= MOST_PLANNED for one in counts):
        return None
    plan = _Plan(*counts)  # type: ignore[arg-type]
    return plan if plan.traces <= MOST_PLANNED else None


def _share(points: int, cells: int) -> np.ndarray:
    """Return how many of the points belong to each cell."""
    return np.bincount(np.arange(points) * cells // points, minlength=cells)


def _is_place(value: Any) -> bool:
    # Compared before it is converted: a whole number of JSON may have hundreds of digits.
    return type(value) in (int, float) and abs(value) <= LARGEST_MM


def _people(annotation: Any) -> Dict[str, Any]:
    """Return what people wrote that a list is searched for."""
    written = annotation if isinstance(annotation, dict) else {}
    return {name: _text(written.get(name)) for name in ("name", "site", "operator")}


def _text(value: Any) -> str:
    if not isinstance(value, str):
        return ""
    # Half of a character, which JSON can hold, cannot be sent: no survey would be listed.
    return value.encode("utf-8", "backslashreplace").decode("utf-8")
