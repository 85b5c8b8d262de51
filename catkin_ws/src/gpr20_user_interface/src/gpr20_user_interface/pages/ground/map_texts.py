"""What MAP says about the place that was touched, and about the survey while none is."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import Cell
from gpr20_operator.ground.map_model import MapModel
from gpr20_survey.results.candidates import Candidate
from gpr20_user_interface.pages.ground.map_selection import Selection

STATE_NAMES: Dict[StopState, Message] = {
    StopState.DONE: Message("Done"),
    StopState.PARTLY: Message("Partly"),
    StopState.MISSING: Message("Missing"),
    StopState.FAILED: Message("Failed"),
}
UNKNOWN = verbatim("—")

Lines = Tuple[Message, ...]


def summary_lines(model: MapModel, additions: AdditionsPresenter) -> Lines:
    """Return what is known of the survey while no place is selected."""
    lines = [] if model.verdict is None else [model.verdict]
    count = len(additions.candidates)
    if count:
        lines.append(Message("{count} candidates; dashed ring: doubtful", count=count))
    for one in additions.related:
        if one.is_finer:
            lines.append(Message("Frame: finer survey {survey}", survey=one.folder))
        else:
            lines.append(Message("This survey refines survey {survey}", survey=one.folder))
    return (*lines, Message("Touch a place of the map."))


def place_lines(selected: Selection, model: MapModel, radar: RadarModel) -> Lines:
    """Return what is known of a place."""
    if selected.candidate is not None:
        return _candidate_lines(selected.candidate, selected)
    if selected.marker is not None:
        marker = selected.marker
        made = f"{marker.time[:16].replace('T', ' ')} UTC {marker.author}".strip()
        return (
            Message("Marker: {text}", text=marker.text or UNKNOWN),
            place_text(selected.x_mm, selected.y_mm, selected.depth_mm),
            verbatim(made),
        )
    cell = selected.cell
    state = model.state_at(cell.stop)
    place = Message(
        "X {x:g} mm, Y {y:g} mm: {state}",
        x=round(selected.x_mm, 2),
        y=round(selected.y_mm, 2),
        state=UNKNOWN if state is None else STATE_NAMES[state],
    )
    return (place, *model.reasons_at(cell.stop), *why_no_trace(cell, model, radar))


def place_text(x_mm: float, y_mm: float, depth_mm: Optional[float]) -> Message:
    """Return a place in words."""
    if depth_mm is None:
        return Message("X {x_mm:.0f} mm, Y {y_mm:.0f} mm", x_mm=x_mm, y_mm=y_mm)
    return Message(
        "X {x_mm:.0f} mm, Y {y_mm:.0f} mm, depth {depth_mm:.0f} mm",
        x_mm=x_mm,
        y_mm=y_mm,
        depth_mm=depth_mm,
    )


def why_no_trace(cell: Cell, model: MapModel, radar: RadarModel) -> Lines:
    """Return why the trace of a stop cannot be shown; empty if it can."""
    if model.grid is None or (radar.grid is not None and radar.has(cell)):
        return ()
    given_up = radar.given_up.get(model.grid.index(cell))
    return (Message("no trace to show") if given_up is None else given_up,)


def _candidate_lines(candidate: Candidate, selected: Selection) -> Lines:
    number = candidate.number
    return (
        Message("Candidate {number}, doubtful", number=number)
        if candidate.is_doubtful
        else Message("Candidate {number}", number=number),
        place_text(selected.x_mm, selected.y_mm, selected.depth_mm),
        Message("{level_db:.0f} dB above the clutter", level_db=candidate.above_clutter_db),
        *candidate.labels,
    )
