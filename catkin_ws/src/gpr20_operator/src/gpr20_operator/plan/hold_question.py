"""What the window says before the robot moves or something is changed: a summary to hold for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.annotation import overwritten, shortened
from gpr20_operator.plan.form import SurveyPreview
from gpr20_operator.plan.tiles import Row, about, plan_rows, spacing_warning
from gpr20_operator.robot.events import Progress
from gpr20_operator.robot.remote_control import WebStatusReported
from gpr20_operator.words import local_time, size_text
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
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
            (Message("To compare again"), Message("STOP, then resume it in ARCHIVE")),
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
