"""What a result says: how many places there are, why each is one, and what that does not mean."""

from __future__ import annotations

from typing import Dict, List, Optional, Tuple

from gpr20_common.message import Message, in_a_row, numeral
from gpr20_operator.ground.past_surveys import (
    PastSurveys,
    past_band,
    survey_label,
)
from gpr20_operator.jobs.result import SurveyResult
from gpr20_operator.words import in_line, local_time, size_text
from gpr20_survey.plan.markers import Found, What
from gpr20_survey.plan.recorded_plan import IMPORTED
from gpr20_survey.radar import ANY_SOIL, soil_of
from gpr20_survey.results.answers import SurveySummary
from gpr20_survey.results.candidates import Candidate, CandidateList, Flag
from gpr20_survey.results.hiding_map import Targets

FROM_MARK = Message("X, Y: mm from the frame's mark")
NOTHING_FOUND = Message("No place stands out")
NOT_SAFE = Message(
    "That does not mean that no mine is there: one that echoes no more than this ground is not "
    'seen. "Where could a mine hide?" shows where.'
)
SEARCHING = Message("Searching for places")
READING = Message("Reading the survey")
TARGETS: Dict[Targets, Message] = {
    Targets.PMN: Message("Mine PMN"),
    Targets.TYPE_72: Message("Mine Type 72"),
    Targets.FRAGMENT: Message("Metal fragment"),
}
FINDS: Dict[What, Message] = {
    What.NOTHING: Message("nothing"),
    What.SCRAP: Message("scrap"),
    What.DEVICE: Message("mine or device"),
}
INCOMPLETE = Message("INCOMPLETE")
OUTCOMES: Dict[str, Message] = {
    "stopped": Message("STOPPED"),
    "failed": Message("FAILED"),
    "interrupted": Message("INTERRUPTED"),
}
MEANINGS: Dict[Flag, Message] = {
    Flag.SURFACE_RESIDUE: Message("Surface residue: so shallow that it may be the surface."),
    Flag.EDGE: Message("Edge: it may lie outside of the measured area."),
    Flag.ONE_POLARIZATION: Message("One polarization: seen with one rotation of the antennas."),
    Flag.CLUTTER: Message("Clutter: no stronger than this ground often is."),
    Flag.SIDELOBE: Message("Sidelobe: it may be left from a much stronger place near it."),
    Flag.BRIGHTEST: Message("No stronger than clutter, but the brightest echo of the survey."),
}


def band(result: SurveyResult) -> Optional[Message]:
    """Return which survey this is; None: that of the robot, or none."""
    record = result.record
    if record is None or record.survey_id == result.latest_id:
        return None
    label = survey_label(record.name, record.survey_id, local_time(record.started))
    band = past_band(label, record.outcome)
    return in_a_row([Message("SIMULATED"), band]) if record.grid.simulated else band


def survey_lines(past: PastSurveys, survey: SurveySummary) -> List[Message]:
    """Return how large a stored survey is, and how it ended."""
    width_mm, height_mm, count = survey.width_mm, survey.height_mm, survey.stored_traces
    lines = (
        size_text(round(width_mm), round(height_mm)) if width_mm else None,
        Message("{count} traces", count=count) if survey.problem is None else None,
        past.ending(survey),
    )
    return [one for one in lines if one is not None]


def headline(found: CandidateList) -> Message:
    """Return how many places there are to check, and how many weaker echoes below them."""
    first = NOTHING_FOUND
    if found.primary:
        count = found.primary
        one = Message("1 place to check")
        first = one if count == 1 else Message("{count} places to check", count=count)
    return in_a_row([first, *([weaker_line(found)] if found.weaker else [])])


def weaker_line(found: CandidateList) -> Message:
    """Return how many echoes are below the cut of the list."""
    if found.weaker == 1:
        return Message("1 weaker echo")
    return Message("{count} weaker echoes", count=found.weaker)


def doubts(result: SurveyResult) -> List[Message]:
    """Return what of the survey may not be believed."""
    return [] if result.image is None else [one for one in result.image.found.notes if one.cause]


def notices(result: SurveyResult) -> List[Message]:
    """Return what else a person must know of the whole list: what is not in it, or was lost."""
    part, image = measured(result), result.image
    lines = [] if part is None else [part]
    if result.soil.problem is not None:
        reason = result.soil.problem
        lines.append(Message("The permittivity is not stored: {reason}", reason=reason))
    if result.record is not None and result.record.unreadable:
        count = result.record.unreadable
        lines.append(Message("{count} entries of the log cannot be read", count=count))
    if image is not None and image.found.omitted:
        lines.append(
            Message("{count} of the weaker echoes are not in the list", count=image.found.omitted)
        )
    return lines


def place_line(place: Candidate) -> Message:
    """Return where a place is."""
    x, y, _ = place.place_texts
    return Message("X {x}  Y {y} mm", x=x, y=y)


def whole_place(place: Candidate) -> Message:
    """Return where a place is, and how deep."""
    across, deep = place_line(place), place.place_texts[2]
    return Message("{across}, {deep} mm deep", across=across, deep=deep)


def why_line(place: Candidate) -> Message:
    """Return in one line how deep a place is, and what to know before believing it."""
    deep = Message("{deep} mm deep", deep=place.place_texts[2])
    return in_a_row([deep, *place.labels])


def why_lines(place: Candidate) -> List[Message]:
    """Return all that is known about why a place is on the list."""
    lines = [Message("{level:.0f} dB above the clutter around it", level=place.above_clutter_db)]
    rotations = [numeral(one) for one in place.rotations_deg]
    if rotations:
        line = in_line(rotations)
        lines.append(Message("Seen with the antennas at {rotations} deg", rotations=line))
    return [*lines, *(MEANINGS[flag] for flag in place.flags)]


def measured(result: SurveyResult) -> Optional[Message]:
    """Return how much of a survey was measured; None: all of it, or that is not known."""
    record, image = result.record, result.image
    if record is None or record.outcome == IMPORTED:
        return None
    stored, planned = record.stored, record.grid.planned
    if stored < planned:
        ended = OUTCOMES.get(record.outcome, INCOMPLETE)
        return Message(
            "{ended}: {stored} of {planned} traces", ended=ended, stored=stored, planned=planned
        )
    if image is not None and image.traces < stored:
        return Message("{count} of {stored} traces could not be read", count=stored - image.traces,
                       stored=stored)  # fmt: skip
    return None


def soil_lines(result: SurveyResult) -> Tuple[Message, Message]:
    """Return the permittivity that everything is made with, and what is known of it."""
    value = result.permittivity
    if result.record is None:
        return Message("Permittivity"), Message("not read yet")
    if value is None:
        image = result.image
        assumed = ANY_SOIL.permittivity if image is None else image.found.permittivity
        return Message("Permittivity {value:.3g}", value=assumed), Message("ASSUMED")
    soil = soil_of(value)
    known = Message("as entered") if soil is None else soil.value.name
    return Message("Permittivity {value:.3g}", value=value), known


def found_line(found: Found) -> Message:
    """Return what people found at a place."""
    what = Message("Found here: {what}", what=FINDS[found.what])
    if found.depth_mm is None:
        return Message("{what} ({who}, {date})", what=what, who=found.who, date=found.time[:10])
    return Message(
        "{what}, {depth:.0f} mm deep ({who}, {date})",
        what=what,
        depth=found.depth_mm,
        who=found.who,
        date=found.time[:10],
    )
