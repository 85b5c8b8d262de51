"""What the window says before the robot moves or something is deleted: a summary to hold for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.preview import SurveyPreview
from gpr20_operator.robot.events import Progress
from gpr20_operator.words import duration
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.results.survey_summary import SurveySummary

Row = Tuple[Message, Message]
# Of an operator or a site; the sheet has no room for more.
LONGEST_NAME = 40
HANDS_CLEAR = Message(
    "Hands clear! The robot homes its axes if necessary, and then moves on its own."
)
HOLD_TO_START = Message("HOLD\nTO START")
HOLD_TO_RESUME = Message("HOLD\nTO RESUME")


@dataclass(frozen=True)
class HoldQuestion:
    """What a sheet says, and the button that must be held.

    Attributes:
        title: What is asked.
        rows: What will happen: names and values.
        warning: What to mind.
        hold: The text of the button.
    """

    title: Message
    rows: Tuple[Row, ...]
    warning: Message
    hold: Message


def start_question(
    parameters: SurveyParameters, preview: SurveyPreview, annotation: Annotation
) -> HoldQuestion:
    """Return what is asked before a survey starts.

    Args:
        parameters: What it measures.
        preview: The figures that follow from them.
        annotation: What people have added to it.
    """
    rows = [
        (Message("Area"), _area(parameters)),
        (
            Message("Spacing"),
            Message("X {x:.4g} mm, Y {y:.4g} mm", x=preview.x_spacing_mm, y=preview.y_spacing_mm),
        ),
        (
            Message("Traces"),
            Message("{traces} at {stops} stops", traces=preview.traces, stops=preview.stops),
        ),
        (Message("Time"), _time(None if preview.cost is None else preview.cost.duration_s)),
        *_people(annotation),
    ]
    return HoldQuestion(Message("Start this survey?"), tuple(rows), HANDS_CLEAR, HOLD_TO_START)


def resume_question(progress: Optional[Progress], zeros_unproven: bool = False) -> HoldQuestion:
    """Return what is asked before the paused survey is resumed.

    Args:
        progress: Of the survey; None if it is not known.
        zeros_unproven: Whether the operator must decide about the zeros of the axes.
    """
    rows: Tuple[Row, ...] = ()
    if progress is not None and progress.total_points:
        rows = (
            (Message("Stored"), _counted(progress.visited_points, progress.total_points)),
            (Message("Time left"), _time(progress.remaining_s)),
        )
    if zeros_unproven:
        rows += (
            (Message("Positions"), Message("NOT PROVEN from here on; the survey keeps saying so")),
            (Message("To compare again"), Message("STOP, then resume it on SURVEYS")),
        )
        return HoldQuestion(Message("Resume as it is?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)
    return HoldQuestion(Message("Resume the survey?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)


def resume_past_question(folder: str, survey: Optional[SurveySummary]) -> HoldQuestion:
    """Return what is asked before a survey that ended early is resumed.

    Args:
        folder: The survey's folder.
        survey: What the list says about it; None if it is not in the list.
    """
    name = "" if survey is None else _short(survey.name)
    rows: Tuple[Row, ...] = ((Message("Survey"), verbatim(name or folder)),)
    if survey is not None:
        rows += (
            (Message("Started"), verbatim(survey.local_time())),
            (Message("Stored"), _counted(survey.stored_traces, survey.planned_traces)),
        )
    return HoldQuestion(Message("Resume this survey?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)


def other_analyzer_question(identity: str) -> HoldQuestion:
    """Return what is asked before a survey is continued with another analyzer."""
    rows = (
        (Message("VNA"), verbatim(identity)),
        (Message("Survey"), Message("It then names both VNAs.")),
    )
    return HoldQuestion(Message("Continue with this VNA?"), rows, HANDS_CLEAR, HOLD_TO_RESUME)


def delete_profile_question(name: str) -> HoldQuestion:
    """Return what is asked before a profile is deleted."""
    return HoldQuestion(
        Message("Delete this profile?"),
        ((Message("Profile"), verbatim(name)),),
        Message("It cannot be restored."),
        Message("HOLD\nTO DELETE"),
    )


def remove_marker_question(place: Message, text: str) -> HoldQuestion:
    """Return what is asked before a marker is removed from its survey."""
    note: Tuple[Row, ...] = ((Message("Note"), verbatim(_short(text))),) if text else ()
    return HoldQuestion(
        Message("Remove this marker?"),
        ((Message("Place"), place), *note),
        Message("It cannot be restored."),
        Message("HOLD\nTO REMOVE"),
    )


def _area(p: SurveyParameters) -> Message:
    return Message(
        "{width:.6g} x {length:.6g} mm: X {x_start:.6g} to {x_stop:.6g}, "
        "Y {y_start:.6g} to {y_stop:.6g}",
        width=abs(p.x_stop_mm - p.x_start_mm),
        length=abs(p.y_stop_mm - p.y_start_mm),
        x_start=p.x_start_mm,
        x_stop=p.x_stop_mm,
        y_start=p.y_start_mm,
        y_stop=p.y_stop_mm,
    )


def _time(duration_s: Optional[float]) -> Message:
    if duration_s is None or not math.isfinite(duration_s):
        return Message("not known yet")
    if duration_s < 60.0:
        return duration(duration_s)
    return Message("about {time}", time=duration(duration_s))


def _counted(stored: int, planned: int) -> Message:
    return Message("{stored} of {planned} traces", stored=stored, planned=planned)


def _people(annotation: Annotation) -> Tuple[Row, ...]:
    known = (
        (Message("Name"), annotation.name),
        (Message("Operator"), annotation.operator),
        (Message("Site"), annotation.site),
    )
    return tuple((title, verbatim(_short(name))) for title, name in known if name)


def _short(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"
