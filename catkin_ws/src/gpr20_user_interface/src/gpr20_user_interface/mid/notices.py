"""What the dialogs say: what happened, what to do next, and technical details."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

from gpr20_common.message import Message
from gpr20_user_interface.mid.events import ControlState, HealthLevel, NodeHealth
from gpr20_user_interface.mid.titles import level_title, node_title

NO_REPORT = Message("no report")


@dataclass(frozen=True)
class Notice:
    """The texts of a dialog.

    Attributes:
        title: What this is about, or what was refused.
        text: What happened.
        next_step: What to do; None: nothing.
        details: Technical lines that are not translated.
    """

    title: Message
    text: Message
    next_step: Optional[Message] = None
    details: Tuple[str, ...] = ()


class Refused(enum.Enum):
    """What did not succeed: a request to the robot, or the use of a profile."""

    START = "start"
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    PROFILE = "profile"
    NOTES = "notes"
    MARKER = "marker"


_REFUSALS: Dict[Refused, Tuple[Message, Message]] = {
    Refused.START: (
        Message("The survey was not started."),
        Message("Next: remove the cause, check STATUS, then press START again."),
    ),
    Refused.STOP: (
        Message("STOP was not accepted."),
        Message("Next: check STATUS. If the robot moves, press STOP again or switch it off."),
    ),
    Refused.PAUSE: (
        Message("The survey was not paused."),
        Message("Next: check STATUS. STOP ends the survey at once; it can be resumed later."),
    ),
    Refused.RESUME: (
        Message("The survey was not resumed."),
        Message("Next: remove the cause, check STATUS, then press RESUME again."),
    ),
    Refused.PROFILE: (
        Message("The profile cannot be used."),
        Message("Next: remove the cause, or use another profile."),
    ),
    Refused.NOTES: (
        Message("The notes of the survey cannot be read or stored."),
        Message("Next: remove the cause, then press SAVE again."),
    ),
    Refused.MARKER: (
        Message("The markers of the survey were not changed."),
        Message("Next: remove the cause, then set or remove the marker again."),
    ),
}


def refusal_notice(refused: Refused, reason: Message) -> Notice:
    """Return what a dialog says about something that did not succeed."""
    title, next_step = _REFUSALS[refused]
    return Notice(title, reason, next_step, reason.all_details)


def analyzer_notice(reason: Message, identity: str) -> Notice:
    """Return what the question says before a survey is continued with another analyzer.

    Args:
        reason: The refusal of the main control, which names both analyzers.
        identity: What the present analyzer says it is.
    """
    return Notice(
        Message("The VNA is not the one of this survey."),
        reason,
        Message(
            "Connect the survey's VNA and press RESUME again, or continue with this VNA. The "
            "survey then names both."
        ),
        (identity, *reason.all_details),
    )


def state_notice(state: ControlState) -> Notice:
    """Return the whole status message of the main control."""
    return Notice(state.title, state.message, details=state.message.all_details)


def node_notice(node: NodeHealth) -> Notice:
    """Return everything that a node reports about itself."""
    title = Message("{name}: {level}", name=node_title(node.name), level=level_title(node.level))
    values = (f"{name}: {value}" for name, value in node.values.items())
    details = (*node.message.all_details, f"node: {node.name}", *values)
    return Notice(title, node_text(node), details=details)


def node_text(node: NodeHealth) -> Message:
    """Return what is known about the health of a node in one sentence."""
    return NO_REPORT if node.level is HealthLevel.STALE else node.message
