"""What GROUND says about the place that was touched, its pictures and the survey."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

import numpy as np

from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.echoes import MIN_BACKGROUND_TRACES
from gpr20_operator.ground.grid import Cell
from gpr20_operator.ground.map_model import MapModel
from gpr20_operator.ground.records import Axis
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate
from gpr20_user_interface.pages.ground.model import GroundModel, Layer, Shown

STATE_NAMES: Dict[StopState, Message] = {
    StopState.DONE: Message("Done"),
    StopState.PARTLY: Message("Partly"),
    StopState.MISSING: Message("Missing"),
    StopState.FAILED: Message("Failed"),
}
NO_CLEARANCE = Message("No echo does not mean no mine.")
UNKNOWN = verbatim("—")
NO_POINTS = np.zeros(0)
Lines = Tuple[Message, ...]


def touched_lines(model: GroundModel, shown: Shown) -> Lines:
    """Return what is known of the place of the crosshair, the most important first."""
    mark, place = model.mark, model.place
    if isinstance(mark, Candidate):
        return candidate_lines(mark, model.is_measured(mark.x_mm, mark.y_mm))
    if isinstance(mark, Marker):
        made = f"{mark.time[:16].replace('T', ' ')} UTC {mark.author}".strip()
        return (
            Message("Marker: {text}", text=mark.text or UNKNOWN),
            place_text(mark.x_mm, mark.y_mm, mark.depth_mm),
            verbatim(made),
        )
    if model.survey.map.grid is None:
        return ()
    cell = model.cell
    if place is None or cell is None:
        return (Message("Touch the ground to see what is below it."),)
    return (
        place_text(place.x_mm, place.y_mm, model.settings.depth_m * 1000.0),
        *_level(model, shown),
        *_state(model, cell),
        *(summary_lines(model) if model.follows else ()),
    )


def candidate_lines(candidate: Candidate, measured: bool) -> Lines:
    """Return what is known of a candidate."""
    return (
        Message("Candidate {number}, doubtful", number=candidate.number)
        if candidate.is_doubtful
        else Message("Candidate {number}", number=candidate.number),
        place_text(candidate.x_mm, candidate.y_mm, candidate.depth_mm),
        Message("{level_db:.0f} dB above the clutter", level_db=candidate.above_clutter_db),
        *(() if measured else (Message("the ground there was not measured"),)),
        *candidate.labels,
    )


def summary_lines(model: GroundModel) -> Lines:
    """Return what is known of the survey while no place is chosen."""
    verdict, additions = model.survey.map.verdict, model.additions
    lines = [] if verdict is None else [verdict]
    if additions.candidates:
        lines.append(counted(additions.candidates))
    for one in additions.related:
        if one.is_finer:
            lines.append(Message("Frame: finer survey {survey}", survey=one.folder))
        else:
            lines.append(Message("This survey refines survey {survey}", survey=one.folder))
    return tuple(lines)


def counted(candidates: Tuple[Candidate, ...]) -> Message:
    """Return how many candidates a person should look at, and how many are doubtful."""
    doubtful = sum(one.is_doubtful for one in candidates)
    count = len(candidates) - doubtful
    if count == 1:
        return Message("1 candidate, {doubtful} doubtful", doubtful=doubtful)
    return Message("{count} candidates, {doubtful} doubtful", count=count, doubtful=doubtful)


def place_text(x_mm: float, y_mm: float, depth_mm: Optional[float]) -> Message:
    """Return a place in words."""
    if depth_mm is None:
        return Message("X {x_mm:.0f}, Y {y_mm:.0f} mm", x_mm=x_mm, y_mm=y_mm)
    return Message(
        "X {x_mm:.0f}, Y {y_mm:.0f}, depth {depth_mm:.0f} mm",
        x_mm=x_mm,
        y_mm=y_mm,
        depth_mm=depth_mm,
    )


def _level(model: GroundModel, shown: Shown) -> Lines:
    """Return the level at the crosshair; empty if it is not known."""
    picture = shown.above or next((one for one in shown.sections if one is not None), None)
    focused, level_db = model.shows_focused, shown.level_db
    if level_db is None or picture is None:
        return ()
    if level_db <= picture.scale.threshold_db:
        return (Message("not above the clutter") if focused else Message("not above the noise"),)
    if focused:
        return (Message("{level_db:.0f} dB above the clutter", level_db=level_db),)
    return (Message("{level_db:.0f} dB above the noise", level_db=level_db),)


def _state(model: GroundModel, cell: Cell) -> Lines:
    """Return what a person should know of a stop; nothing of one that is done and shown."""
    ground = model.survey.map
    state, reasons = ground.state_at(cell.stop), ground.reasons_at(cell.stop)
    lines = [] if state in (None, StopState.DONE) else [STATE_NAMES[state]]
    return (*lines, *reasons, *why_no_trace(cell, ground, model))


def why_no_trace(cell: Cell, ground: MapModel, model: GroundModel) -> Lines:
    """Return why the trace of a stop cannot be shown; empty if it can."""
    radar = model.survey.radar
    if ground.grid is None or (radar.grid is not None and radar.has(cell)):
        return ()
    if model.survey.loading.waiting[cell.polarization, cell.stop.row, cell.stop.column]:
        return (Message("this trace is being loaded"),)
    given_up = radar.given_up.get(ground.grid.index(cell))
    return (Message("no trace to show") if given_up is None else given_up,)


def notes(model: GroundModel) -> Lines:
    """Return what must always be known about the pictures; it is never left out."""
    grid = model.survey.map.grid
    simulated = grid is not None and grid.simulated
    return (*((Message("SIMULATED."),) if simulated else ()), NO_CLEARANCE)


def remark(model: GroundModel) -> Message:
    """Return the most important remark; there is no room for more."""
    loading, radar, settings = model.survey.loading, model.survey.radar, model.settings
    if radar.grid is None:
        return verbatim("")
    if model.is_loading:
        return Message(
            "Dashes: loading {loaded}/{stored}.", loaded=loading.loaded, stored=loading.stored
        )
    if Layer.HIDING in model.layers and model.additions.hiding is not None:
        return Message("Hatched: a mine could hide here.")
    if radar.given_up:
        return Message("Cannot be shown: {count}.", count=len(radar.given_up))
    if model.shows_focused and model.image is not None:
        return Message("Focused with permittivity {value:g}.", value=model.image.found.permittivity)
    lacks = settings.remove_background and bool(radar.count)
    if lacks and radar.background(settings.polarization) is None:
        return Message(
            "The background is not removed from fewer than {count} traces.",
            count=MIN_BACKGROUND_TRACES,
        )
    return Message("Dotted: not measured.")


def above_notice(model: GroundModel, shown: Shown, problem: Optional[Message]) -> Lines:
    """Return what to write over the view from above.

    Args:
        model: What is chosen.
        shown: What is shown.
        problem: Why there is no newer focused image.
    """
    grid, radar = model.survey.map.grid, model.survey.radar
    if grid is None:
        return (
            Message("No survey yet."),
            Message("Start one under Survey, or open a stored one under Archive."),
        )
    if Layer.FOCUSED in model.layers and not model.shows_focused:
        echoes = Message("The image is not focused yet. These are the echoes.")
        return (echoes,) if problem is None else (problem, echoes)
    if not {Layer.ECHOES, Layer.FOCUSED} & model.layers or not radar.count:
        return ()
    if shown.above is None:
        return (Message("No height was measured: the depth is unknown."),)
    return _nothing(model, shown.above.measured, shown.above.above_noise, "slice")


def section_notice(model: GroundModel, measured: bool, above_noise: bool) -> Lines:
    """Return what to write over a section."""
    return _nothing(model, measured, above_noise, "section")


def _nothing(model: GroundModel, measured: bool, above_noise: bool, kind: str) -> Lines:
    """Return that nothing is seen; never while a part of it is not here."""
    if not measured or above_noise or model.is_loading:
        return ()
    found = {
        ("slice", False): Message("Nothing above the noise at this depth."),
        ("slice", True): Message("Nothing above the clutter at this depth."),
        ("section", False): Message("Nothing above the noise in this section."),
        ("section", True): Message("Nothing above the clutter in this section."),
    }[kind, model.shows_focused]
    partial = (Message("A part is not measured."),) if model.is_partial else ()
    return (found, *partial, NO_CLEARANCE)


def section_title(model: GroundModel, along: Axis, in_time: bool) -> Tuple[str, Message]:
    """Return the titles of both axes of a section, with where it is."""
    place = model.place
    at_mm = 0.0 if place is None else place.y_mm if along is Axis.X_MM else place.x_mm
    if along is Axis.X_MM:
        second = (
            Message("Delay ns, at Y {at:.0f} mm", at=at_mm)
            if in_time
            else Message("Depth mm, at Y {at:.0f} mm", at=at_mm)
        )
        return "X mm", second
    second = (
        Message("Delay ns, at X {at:.0f} mm", at=at_mm)
        if in_time
        else Message("Depth mm, at X {at:.0f} mm", at=at_mm)
    )
    return "Y mm", second


def depth_title(model: GroundModel, has_image: bool) -> Message:
    """Return the title of the second axis of the view from above, with its depth."""
    if not has_image:
        return Message("Y mm")
    depth_mm = model.settings.depth_m * 1000.0
    if model.shows_focused:
        return Message("Y mm, focused, {depth_mm:.0f} mm deep", depth_mm=depth_mm)
    return Message("Y mm, echoes, {depth_mm:.0f} mm deep", depth_mm=depth_mm)
