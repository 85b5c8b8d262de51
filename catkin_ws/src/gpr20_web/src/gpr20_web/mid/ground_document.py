"""What a browser is sent about the ground, besides the pictures."""

from __future__ import annotations

from typing import Any, Callable, Dict, Iterable, List, Optional

import numpy as np

from gpr20_common.message import Message
from gpr20_operator.ground import texts
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.geometry import Area, shown_area, survey_area
from gpr20_operator.ground.marks import GroundMark, marks_above, marks_in_section
from gpr20_operator.ground.model import GroundModel, Shown
from gpr20_operator.ground.records import Axis, Picture
from gpr20_survey.results.candidates import Candidate
from gpr20_web.mid.ground_choice import MM_PER_M, GroundChoice
from gpr20_web.mid.shown_ground import ShownGround

Text = Callable[[Message], str]
# Single stops that failed must not be overlooked among thousands.
MAX_RINGS = 60


def document(ground: ShownGround, choice: GroundChoice, text: Text) -> Dict[str, Any]:
    """Return a choice of a survey for a browser; areas are left, right, low and high."""
    shown, model = ground.show(choice), ground.model
    survey, settings, image, place = model.survey.map, model.settings, model.image, model.place
    counts, deepest_m, hiding = survey.counts(), model.deepest_m, ground.additions.hiding
    above = texts.above_notice(model, shown, ground.imaging.problem) if survey.grid else ()
    return {
        "counts": [
            [state.name.lower(), text(name), None if counts is None else counts[state]]
            for state, name in texts.STATE_NAMES.items()
        ],
        "polarization": settings.polarization,
        "depth_mm": round(settings.depth_m * MM_PER_M),
        "deepest_mm": None if deepest_m is None else round(deepest_m * MM_PER_M),
        "notes": _said((*texts.notes(model), texts.remark(model)), text),
        "notice": _said(above, text),
        "lines": _said(texts.touched_lines(model, shown), text),
        "place": None if place is None else [place.x_mm, place.y_mm],
        "marks": [_mark(one, text) for one in marks_above(model)],
        "layers": {
            **{name: _area(one.area) for name, one in ground.patterns().items()},
            **({} if shown.above is None else {"image": _extent(shown.above)}),
        },
        "hiding": [] if hiding is None else _said(hiding.sentences, text),
        "traces_focused": None if image is None else image.traces,
        "bar": _bar(shown.first),
        "section": _section(model, shown, text) if choice.alongs else None,
        **_plan(model, text),
    }


def _plan(model: GroundModel, text: Text) -> Dict[str, Any]:
    """Return what follows from the plan of the survey."""
    grid, states = model.survey.map.grid, model.survey.map.stop_states
    if grid is None:
        return {"area": None}
    related = [one.area for one in model.additions.related]
    xs_mm, ys_mm = grid.xs_mm, grid.ys_mm
    failed = () if states is None else np.argwhere(states == StopState.FAILED)[:MAX_RINGS].tolist()
    return {
        "polarizations": [
            text(Message("{rotation:g}°", rotation=one)) for one in grid.rotations_deg
        ],
        "area": _area(shown_area(survey_area(xs_mm, ys_mm), related)),
        "steps_mm": [float(np.ptp(one)) / max(1, len(one) - 1) or 1.0 for one in (xs_mm, ys_mm)],
        "frames": list(map(_area, related)),
        "failed": [[float(xs_mm[column]), float(ys_mm[row])] for row, column in failed],
    }


def _section(model: GroundModel, shown: Shown, text: Text) -> Optional[Dict[str, Any]]:
    picture, place, along = shown.sections[0], model.place, model.settings.along
    if picture is None or place is None:
        return None
    in_time = picture.axis is Axis.DELAY_NS
    across, second = texts.section_title(model, along, in_time)
    return {
        "extent": _extent(picture),
        "titles": [across, text(second)],
        "notice": _said(texts.nothing_in(model, picture, along), text),
        "in_time": in_time,
        "at": [place.along(along), model.second_of(model.settings.depth_m, picture.axis)],
        "columns": picture.shades.shape[1],
        "loading": np.flatnonzero(model.waiting_along(along)).tolist(),
        "marks": [] if in_time else [_mark(one, text) for one in marks_in_section(model, along)],
    }


def _mark(mark: GroundMark, text: Text) -> Dict[str, Any]:
    about: Any = mark.about
    is_candidate = isinstance(about, Candidate)
    lines = (
        texts.candidate_lines(about, mark.measured) if is_candidate else texts.marker_lines(about)
    )
    return {
        "at": [mark.across_mm, mark.second_mm],
        "number": mark.text,
        "candidate": is_candidate,
        "doubtful": mark.doubtful or not mark.measured,
        "near": mark.near,
        "place": [about.x_mm, about.y_mm, about.depth_mm],
        "lines": _said(lines, text),
    }


def _bar(picture: Optional[Picture]) -> List[List[float]]:
    """Return round levels [dB above noise], and where they are on the bar of colours, from 0."""
    if picture is None:
        return []
    scale, low = picture.scale, 0.5 if picture.signed else 0.0
    ticks_db = scale.ticks_db().tolist()
    return [[one, low + (1.0 - low) * scale.shade_of(one)] for one in ticks_db]


def _area(area: Area) -> List[float]:
    return [area.left_mm, area.right_mm, area.low_mm, area.high_mm]


def _extent(picture: Picture) -> List[float]:
    return [*picture.across_mm, *picture.range]


def _said(lines: Iterable[Message], text: Text) -> List[str]:
    return [one[:1].upper() + one[1:] for one in map(text, lines) if one]
