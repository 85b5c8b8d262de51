"""What GROUND says about the place that was touched, its pictures and the survey, and its marks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.echoes import MIN_BACKGROUND_TRACES
from gpr20_operator.ground.model import Found, GroundModel, Shown
from gpr20_operator.ground.sources import Axis, Layer, Picture
from gpr20_operator.jobs.result_texts import headline
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.trace.utc_time import moment_text

STATE_NAMES: Dict[StopState, Message] = {
    StopState.DONE: Message("Done"),
    StopState.PARTLY: Message("Partly"),
    StopState.MISSING: Message("Missing"),
    StopState.FAILED: Message("Failed"),
}
HATCHED = Message("Hatched: a mine could hide here.")
NO_CLEARANCE = Message("No echo does not mean no mine.")
NO_SURVEY = Message("Nothing is measured yet. Start a survey, or open a stored one.")
# While one begins: its plan comes with its first trace.
BEGINS = Message("The survey begins. Nothing of it is measured yet.")
NO_SIGNAL = Message("Nothing above the noise here.")
NO_ECHO = Message("Nothing above the clutter here.")
Lines = Tuple[Message, ...]


def touched_lines(model: GroundModel, shown: Shown) -> Lines:
    """Return what is known of the place of the crosshair, the most important first."""
    mark, place = model.mark, model.place
    if isinstance(mark, Candidate):
        return candidate_lines(mark, model.is_measured(mark.x_mm, mark.y_mm))
    if isinstance(mark, Marker):
        return marker_lines(mark)
    if model.survey.map.grid is None:
        return ()
    if place is None or model.stop is None:
        return (Message("Touch the ground to see what is below it."),)
    return (
        place_text(place.x_mm, place.y_mm, model.settings.depth_m * 1000.0),
        *_level(model, shown),
        *_state(model),
        *(_answer(model) if model.follows else ()),
    )


def marker_lines(marker: Marker) -> Lines:
    return (
        Message("Marker: {text}", text=marker.text or verbatim("—")),
        place_text(marker.x_mm, marker.y_mm, marker.depth_mm),
        moment_text(f"{marker.time[:16]} UTC {marker.author}".strip()),
    )


def candidate_lines(candidate: Candidate, measured: bool) -> Lines:
    return (
        Message("Candidate {number}, weaker echo", number=candidate.number)
        if candidate.is_doubtful
        else Message("Candidate {number}", number=candidate.number),
        place_text(candidate.x_mm, candidate.y_mm, candidate.depth_mm),
        Message("{level_db:.0f} dB above the clutter", level_db=candidate.above_clutter_db),
        *(() if measured else (Message("the ground there was not measured"),)),
        *candidate.labels,
    )


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


def _answer(model: GroundModel) -> Lines:
    """Return how many places there are to check; empty while that is not known."""
    image = model.image
    return () if image is None or not image.found.total else (headline(image.found),)


def _level(model: GroundModel, shown: Shown) -> Lines:
    """Return the level at the crosshair; empty if it is not known."""
    picture, focused, level_db = shown.above or shown.section, model.shows_focused, shown.level_db
    if level_db is None or picture is None:
        return ()
    if level_db <= picture.scale.threshold_db:
        return (Message("not above the clutter") if focused else Message("not above the noise"),)
    if focused:
        return (Message("{level_db:.0f} dB above the clutter", level_db=level_db),)
    return (Message("{level_db:.0f} dB above the noise, not judged", level_db=level_db),)


def _state(model: GroundModel) -> Lines:
    """Return what a person should know of a stop; nothing of one that is done and shown."""
    survey, stop, number = model.survey, model.stop, model.settings.polarization
    ground, radar = survey.map, survey.radar
    if ground.grid is None or ground.stop_states is None or stop is None:
        return ()
    state, trace = StopState(int(ground.stop_states[stop])), (number, *stop)
    lines = [] if state is StopState.DONE else [STATE_NAMES[state]]
    lines.extend(ground.reasons_at(stop))
    if survey.loading.waiting[trace]:
        lines.append(Message("this trace is being loaded"))
    elif not radar.present[trace]:
        index = ground.grid.index(stop, number)
        lines.append(radar.given_up.get(index, Message("no trace to show")))
    return tuple(lines)


def notes(model: GroundModel) -> Lines:
    """Return what must always be known about the pictures; it is never left out."""
    grid = model.survey.map.grid
    simulated = grid is not None and grid.simulated
    return (Message("SIMULATED."), NO_CLEARANCE) if simulated else (NO_CLEARANCE,)


def remark(model: GroundModel) -> Message:
    """Return the most important remark; there is no room for more."""
    loading, radar, settings = model.survey.loading, model.survey.radar, model.settings
    if radar.grid is None:
        return verbatim("")
    if model.waiting is not None:
        return Message(
            "Dashes: loading {loaded}/{stored}.", loaded=loading.loaded, stored=loading.stored
        )
    if settings.layer is Layer.HIDING and model.additions.hiding is not None:
        return HATCHED
    if radar.given_up:
        return Message("Cannot be shown: {count}.", count=len(radar.given_up))
    if model.shows_focused and model.image is not None:
        return Message("Focused with permittivity {value:g}.", value=model.image.found.permittivity)
    if radar.count and radar.background(settings.polarization) is None:
        return Message(
            "The background is not removed from fewer than {count} traces.",
            count=MIN_BACKGROUND_TRACES,
        )
    return Message("Dotted: not measured.")


def above_notice(model: GroundModel, shown: Shown, problem: Optional[Message]) -> Lines:
    """Return what to write over the view from above; `problem`: why there is no newer image."""
    if model.survey.map.grid is None:
        return (NO_SURVEY,)
    if model.settings.layer is Layer.FOCUSED and not model.shows_focused:
        echoes = Message("The image is not focused yet. These are the echoes.")
        return (echoes,) if problem is None else (problem, echoes)
    if not model.has_depth or not model.survey.radar.count:
        return ()
    if shown.above is None:
        return (Message("No height was measured: the depth is unknown."),)
    return nothing_in(model, shown.above, False)


def nothing_in(model: GroundModel, picture: Picture, in_section: bool) -> Lines:
    """Return that nothing is seen in the section, or in the view from above.

    Never while a part of it is not here, nor over a candidate: a list has fainter ones, too.
    """
    if not picture.measured or picture.above_noise or model.waiting is not None:
        return ()
    lies = lies_in_section if in_section else lies_at_depth
    if any(lies(model, one) for one in model.additions.candidates):
        return ()
    partial = (Message("A part is not measured."),) if model.is_partial else ()
    return (NO_ECHO if model.shows_focused else NO_SIGNAL, *partial, NO_CLEARANCE)


def section_title(model: GroundModel) -> Tuple[str, Message]:
    """Return the titles of both axes of the section, with where it is."""
    place, along_x = model.place, model.settings.along is Axis.X_MM
    across, other = ("X mm", "Y") if along_x else ("Y mm", "X")
    at_mm = 0.0 if place is None else place.y_mm if along_x else place.x_mm
    return across, Message("Depth mm, at {axis} {at:.0f} mm", axis=other, at=at_mm)


def depth_title(model: GroundModel, has_image: bool) -> Message:
    """Return the title of the second axis of the view from above, with its depth."""
    depth_mm = model.settings.depth_m * 1000.0
    if not has_image:
        return Message("Y mm")
    if model.shows_focused:
        return Message("Y mm, focused, {depth_mm:.0f} mm deep", depth_mm=depth_mm)
    return Message("Y mm, raw echoes, {depth_mm:.0f} mm deep", depth_mm=depth_mm)


# What is nearer than this to a slice or section lies in it.
NEAR_MM = 25.0


@dataclass(frozen=True)
class GroundMark:
    """A candidate is a ring, a marker is a flag.

    Attributes:
        across_mm: Where it is along the first axis.
        second_mm: Where it is along the second axis: Y, or the depth.
        text: Inside of the ring.
        doubtful: Its ring is dashed.
        chosen: It is what the operator looks at.
        measured: Whether the ground there was measured; else the ring is grey and dashed.
        near: Whether it lies at what is shown; what does not is small and has no text.
        about: What a touch of it is about.
    """

    across_mm: float
    second_mm: float
    text: str
    is_flag: bool = False
    doubtful: bool = False
    chosen: bool = False
    measured: bool = True
    near: bool = True
    about: object = None


def marks_above(model: GroundModel) -> Tuple[GroundMark, ...]:
    """Return what is marked from above; what must not be overlooked comes last."""
    found = []
    for one in _marked(model):
        near = not model.has_depth or one.depth_mm is None or lies_at_depth(model, one)
        # A candidate that is not doubtful has its number at every depth.
        sure = isinstance(one, Candidate) and not one.is_doubtful
        found.append(_mark(model, one, one.x_mm, one.y_mm, near or sure or one == model.mark))
    return tuple(found)


def marks_in_section(model: GroundModel) -> Tuple[GroundMark, ...]:
    """Return what is marked in the section; what is far from it is left out."""
    along_x = model.settings.along is Axis.X_MM
    return tuple(
        _mark(model, one, one.x_mm if along_x else one.y_mm, one.depth_mm, True)
        for one in _marked(model)
        if one.depth_mm is not None and lies_in_section(model, one)
    )


def lies_at_depth(model: GroundModel, one: Found) -> bool:
    """Return whether a candidate or marker lies in the view from above."""
    depth_mm = model.settings.depth_m * 1000.0
    return one.depth_mm is not None and abs(one.depth_mm - depth_mm) <= NEAR_MM


def lies_in_section(model: GroundModel, one: Found) -> bool:
    """Return whether a candidate or marker lies in the section."""
    place, along_x = model.place, model.settings.along is Axis.X_MM
    if place is None:
        return False
    return abs(one.y_mm - place.y_mm if along_x else one.x_mm - place.x_mm) <= NEAR_MM


def _marked(model: GroundModel) -> Tuple[Found, ...]:
    """Return candidates and markers, those that must not be overlooked last."""
    found: Tuple[Found, ...] = (*model.additions.markers, *model.additions.candidates[::-1])
    last = sorted(
        found, key=lambda one: (one == model.mark, getattr(one, "is_doubtful", True) is False)
    )
    return tuple(last)


def _mark(
    model: GroundModel, one: Found, across_mm: float, second_mm: float, near: bool
) -> GroundMark:
    at_mm, chosen = (across_mm, second_mm), one == model.mark
    if isinstance(one, Marker):
        return GroundMark(*at_mm, "", is_flag=True, chosen=chosen, near=near, about=one)
    return GroundMark(
        *at_mm, str(one.number),
        doubtful=one.is_doubtful, chosen=chosen, near=near, about=one,
        measured=model.is_measured(one.x_mm, one.y_mm),
    )  # fmt: skip
