"""The plan in words: its tiles, why START waits, and what is asked before a button is held."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.past_surveys import Ending, PastSurveys
from gpr20_operator.plan.fields import TILE_FIELDS, Tile, texts_of
from gpr20_operator.plan.form import PlanCheck, SurveyPreview, overwritten, shortened
from gpr20_operator.robot.events import Progress, Request
from gpr20_operator.robot.remote_control import WebStatusReported
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.words import (
    duration,
    entered_number,
    in_line,
    local_time,
    number_from_text,
    number_text,
    size_text,
)
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.radar import soil_of
from gpr20_survey.results.answers import SurveySummary

HANDS_CLEAR = Message(
    "Hands clear! The robot homes if necessary; then X, Y and the antennas move on their own. "
    "Nothing may be in their way."
)
HOLD_TO_START = Message("HOLD\nTO START")
HOLD_TO_RESUME = Message("HOLD\nTO RESUME")
REMOTE_WARNING = Message(
    "Hands clear! For 10 min the person in control can start and resume from far away. Any touch "
    "here ends it, and so does a fault."
)
CANNOT_BE_RESTORED = Message("It cannot be restored.")

Lines = Tuple[Message, ...]
Row = Tuple[Message, Message]
BYTES_PER_MEGABYTE, BYTES_PER_GIGABYTE = 1.0e6, 1.0e9
# Of rotations in a row; the sheet has no room for more.
MOST_ROTATIONS = 6


def tile_lines(tile: Tile, texts: Mapping[str, str], annotation: Annotation) -> Lines:
    """Return the two lines of a tile."""
    return {
        Tile.AREA: lambda: (_range("x", texts), _range("y", texts)),
        Tile.SPACING: lambda: _spacing(texts),
        Tile.SOIL: lambda: _soil(texts["permittivity"]),
        Tile.NAME: lambda: _people(annotation),
        Tile.FREQUENCIES: lambda: _frequencies(texts),
        Tile.ANTENNAS: lambda: _antennas(texts["polarizations_deg"]),
        Tile.VNA: lambda: _analyzer(texts),
    }[tile]()


def tile_problem(tile: Tile, check: PlanCheck) -> Optional[Message]:
    """Return what is wrong in a tile, first field first; None if it is right."""
    wrong = (name for name in TILE_FIELDS[tile] if name in check.problems)
    return next(map(check.problem_of, wrong), None)


def plan_rows(
    parameters: SurveyParameters, permittivity: float, known: SurveyPreview, annotation: Annotation
) -> Tuple[Row, ...]:
    """Return everything that a survey will do, as the tiles call it."""
    texts = {
        **texts_of(parameters),
        "x_spacing_mm": number_text(known.x_spacing_mm),
        "y_spacing_mm": number_text(known.y_spacing_mm),
        "permittivity": number_text(permittivity),
    }
    rows = [(tile.value, _joined(tile_lines(tile, texts, annotation))) for tile in Tile]
    size = Message("{traces} at {stops} stops", traces=known.traces, stops=known.stops)
    return (*rows, (Message("Traces"), size), (Message("Time"), cost_text(known)))


def cost_text(known: SurveyPreview) -> Message:
    """Return time and disk space of a survey."""
    cost = known.cost
    if cost is None or not math.isfinite(cost.duration_s):
        return Message("not known yet")
    return Message(
        "{time}, {size} on the disk", time=about(cost.duration_s), size=_size(cost.size_bytes)
    )


def about(duration_s: Optional[float]) -> Message:
    """Return a time that is estimated."""
    if duration_s is None or not math.isfinite(duration_s):
        return Message("not known yet")
    if duration_s < 60.0:
        return duration(duration_s)
    return Message("about {time}", time=duration(duration_s))


def short_size(known: Optional[SurveyPreview]) -> Message:
    """Return traces and time of a survey; empty if its parameters are wrong."""
    if known is None:
        return verbatim("")
    if known.cost is None:
        return Message("{traces} traces", traces=known.traces)
    time = duration(known.cost.duration_s)
    return Message("{traces} traces, {time}", traces=known.traces, time=time)


def spacing_warning(known: SurveyPreview) -> Optional[Message]:
    """Return the warning that the stops are too far apart for the soil; None if they are not."""
    if not known.too_coarse:
        return None
    return Message(
        "Measured every {spacing:.4g} mm: targets can be missed. At most {quarter:.3g} mm in this "
        "soil.",
        spacing=max(known.x_spacing_mm, known.y_spacing_mm),
        quarter=known.quarter_wavelength_mm,
    )


def start_lock(snapshot: Optional[Snapshot], check: PlanCheck) -> Optional[Message]:
    """Return why no survey can be started now; None if one can."""
    if snapshot is not None and snapshot.replay:
        return Message("A replay is shown")
    if snapshot is None or not snapshot.control_alive:
        return Message("No contact with the robot")
    if Request.START in snapshot.pending:
        return Message("The survey is starting")
    if snapshot.running:
        return Message("A survey is running")
    wrong = next((tile for tile in Tile if tile_problem(tile, check) is not None), None)
    return None if wrong is None else Message("Correct first: {tile}", tile=wrong.value)


def resumable(past: PastSurveys, snapshot: Optional[Snapshot]) -> Optional[SurveySummary]:
    """Return the last survey if it ended early and can be resumed now; None if it cannot."""
    if snapshot is None or not snapshot.can_start:
        return None
    measured = (one for one in past.surveys if past.ending_of(one) is not Ending.IMPORTED)
    last = next(measured, None)
    return last if last is not None and past.can_resume(last) else None


def resume_lines(past: PastSurveys, survey: SurveySummary) -> Lines:
    """Return the lines of the tile that resumes a survey."""
    counts = {"stored": survey.stored_traces, "planned": survey.planned_traces}
    name = verbatim(shortened(survey.name)) if survey.name.strip() else past.title_of(survey)
    return name, Message("{stored} of {planned} stored", **counts)


def _range(axis: str, texts: Mapping[str, str]) -> Message:
    # A longer number would be cut off.
    start, stop = (entered_number(texts[f"{axis}_{end}_mm"], ".5g") for end in ("start", "stop"))
    return Message("{axis} {start} - {stop} mm", axis=axis.upper(), start=start, stop=stop)


def _spacing(texts: Mapping[str, str]) -> Lines:
    x, y = (entered_number(texts[f"{axis}_spacing_mm"], ".4g") for axis in "xy")
    points = Message("{x} x {y} points", x=texts["x_points"], y=texts["y_points"])
    size = Message("{x} mm", x=x) if x == y else Message("{x} x {y} mm", x=x, y=y)
    return size, points


def _soil(permittivity: str) -> Lines:
    try:
        soil = soil_of(number_from_text(permittivity))
    except InvalidValueError:
        soil = None
    name = Message("Own value") if soil is None else soil.value.name
    return name, Message("permittivity {value}", value=entered_number(permittivity))


def _people(annotation: Annotation) -> Lines:
    known = (annotation.operator, annotation.site)
    people = " · ".join(shortened(one) for one in known if one)
    name = verbatim(shortened(annotation.name)) if annotation.name else Message("no name")
    return name, verbatim(people)


def _frequencies(texts: Mapping[str, str]) -> Lines:
    start, stop = (entered_number(texts[f"{end}_frequency_hz"]) for end in ("start", "stop"))
    return (
        Message("{start} to {stop} MHz", start=start, stop=stop),
        Message("{count} points", count=texts["frequency_points"]),
    )


def _antennas(text: str) -> Lines:
    parts = (one.strip() for one in text.split(";" if ";" in text else ","))
    rotations = [entered_number(one) for one in parts if one]
    more = [verbatim("…")] if len(rotations) > MOST_ROTATIONS else []
    shown = Message("{rotations}°", rotations=in_line([*rotations[:MOST_ROTATIONS], *more]))
    if len(rotations) == 1:
        return shown, Message("1 trace per stop")
    return shown, Message("{count} traces per stop", count=len(rotations))


def _analyzer(texts: Mapping[str, str]) -> Lines:
    address, averages = texts["vna_address"], texts["averages"]
    bandwidth, power = texts["if_bandwidth_hz"], texts["output_power"]
    made = (
        *([Message("{hertz} Hz", hertz=entered_number(bandwidth))] if bandwidth else []),
        *(verbatim(one) for one in (f"{averages} x" if averages else "", power) if one),
    )
    return (
        verbatim(address) if address else Message("usual address"),
        in_line(made) if made else Message("as set on the VNA"),
    )


def _size(size_bytes: float) -> Message:
    if size_bytes >= BYTES_PER_GIGABYTE:
        return Message("{size:.3g} GB", size=size_bytes / BYTES_PER_GIGABYTE)
    return Message("{size:.3g} MB", size=size_bytes / BYTES_PER_MEGABYTE)


def _joined(lines: Lines) -> Message:
    """Return lines as one."""
    first, second = lines
    if not second.sentence():
        return first
    return Message("{first}, {second}", first=first, second=second)


@dataclass(frozen=True)
class HoldQuestion:
    """What a sheet says, and the button that must be held.

    Attributes:
        rows: What will happen: names and values.
        hold: The text of the button; None: there is nothing to hold for.
        doubt: Why the plan may not serve its purpose; None: no reason is known.
    """

    title: Message
    rows: Tuple[Row, ...]
    warning: Message
    hold: Optional[Message]
    doubt: Optional[Message] = None


def plan_question(
    parameters: SurveyParameters,
    permittivity: float,
    known: SurveyPreview,
    annotation: Annotation,
) -> HoldQuestion:
    """Return all that a survey will do, and why it may not serve its purpose."""
    rows, doubt = plan_rows(parameters, permittivity, known, annotation), spacing_warning(known)
    return HoldQuestion(Message("Start this survey?"), rows, HANDS_CLEAR, HOLD_TO_START, doubt)


def resume_question(progress: Optional[Progress], zeros_unproven: bool = False) -> HoldQuestion:
    """Return what is asked before the paused survey is resumed; progress None: not known."""
    rows: Tuple[Row, ...] = ()
    if progress is not None and progress.total_points:
        rows = (
            (Message("Stored"), _counted(progress.visited_points, progress.total_points)),
            (Message("Time left"), about(progress.remaining_s)),
        )
    if zeros_unproven:
        rows += (
            (Message("Positions"), Message("NOT PROVEN from here on; the survey keeps saying so")),
            (Message("To compare again"), Message("STOP, then resume it in SURVEYS")),
        )
        return HoldQuestion(Message("Resume as it is?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)
    return HoldQuestion(Message("Resume the survey?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)


def resume_past_question(folder: str, survey: Optional[SurveySummary]) -> HoldQuestion:
    """Return what is asked before a survey that ended early is resumed."""
    name = folder if survey is None or not survey.name else shortened(survey.name)
    rows: Tuple[Row, ...] = ((Message("Survey"), verbatim(name)),)
    if survey is not None:
        rows += (
            (Message("Started"), local_time(survey.started, survey.folder)),
            (Message("Stored"), _counted(survey.stored_traces, survey.planned_traces)),
        )
        if survey.width_mm or survey.height_mm:
            rows += ((Message("Area"), size_text(survey.width_mm, survey.height_mm)),)
    rows += ((Message("Plan"), Message("that of the survey, not the one on this page")),)
    return HoldQuestion(Message("Resume this survey?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)


def other_analyzer_question(reason: Message) -> HoldQuestion:
    """Return what is asked before a survey is continued with another analyzer."""
    rows = (Message("VNA"), reason), (Message("Survey"), Message("It then names both VNAs."))
    return HoldQuestion(Message("Continue with this VNA?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)


def change_records_question(survey: str, before: Annotation, after: Annotation) -> HoldQuestion:
    """Return what is asked before the records of a survey that exists are changed."""
    rows = ((Message("Survey"), verbatim(survey)), *overwritten(before, after))
    warning = Message("The survey shows the new records; its log keeps the old ones.")
    return HoldQuestion(Message("Change these records?"), rows, warning, Message("HOLD\nTO CHANGE"))


def remove_marker_question(place: Message, text: str) -> HoldQuestion:
    """Return what is asked before a marker is removed from its survey."""
    note: Tuple[Row, ...] = ((Message("Note"), verbatim(shortened(text))),) if text else ()
    rows = ((Message("Place"), place), *note)
    return HoldQuestion(
        Message("Remove this marker?"), rows, CANNOT_BE_RESTORED, Message("HOLD\nTO REMOVE")
    )


def remote_question(web: Optional[WebStatusReported], obstacle: Optional[Message]) -> HoldQuestion:
    """Return what is asked before somebody elsewhere may start and resume.

    Args:
        web: What the web page says of itself; None: there is none.
        obstacle: Why it is not possible now; None: it is.
    """
    title = Message("Allow remote control?")
    rows: Tuple[Row, ...] = ()
    if web is None:
        obstacle = obstacle or Message("The robot has no web page. Start it with web:=true.")
    else:
        rows = (
            (Message("Page"), verbatim(web.url)),
            (Message("Certificate"), verbatim(web.fingerprint)),
            (Message("Open at"), Message("{count} browsers", count=web.watchers)),
            (Message("In control"), verbatim(web.controller or "—")),
        )
    if obstacle is not None:
        return HoldQuestion(title, rows, verbatim(""), None, obstacle)
    return HoldQuestion(title, rows, REMOTE_WARNING, Message("HOLD\nTO ALLOW"))


def _counted(stored: int, planned: int) -> Message:
    return Message("{stored} of {planned} traces", stored=stored, planned=planned)
