"""What a client shows of the robot on every page: by its motion, its codes and their age.

The state of a survey is the last thing that counts: what moves, who is silent and what stands
still comes first. No dialog and no request changes the result.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Dict, Iterator, NamedTuple, Optional, Tuple

from gpr20_common.faults import MAY_MOVE, NOT_RUNNING, PART_LOST, PART_SILENT
from gpr20_common.message import Message, Severity, in_a_row
from gpr20_doctor.faults import MASTER_LOST
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator import faults
from gpr20_operator.robot.events import Request
from gpr20_operator.robot.snapshot import Snapshot, percent_of, progress_of
from gpr20_operator.words import time_left
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import AXIS_MAY_MOVE, CAN_RESUME, TAKES_LONG
from gpr20_survey.plan.survey_state import SurveyState


class JobLevel(enum.Enum):
    """How it is going; each level has a colour, a sign and a pattern of its own."""

    WORKING = "working"
    PAUSED = "paused"
    ATTENTION = "attention"
    FAULT = "fault"
    DONE = "done"
    REST = "rest"
    REPLAY = "replay"


# Their remedies say themselves to keep away.
_HANDS_OFF = {
    one.remedy for one in (MASTER_LOST, PART_LOST, MAY_MOVE, AXIS_MAY_MOVE, faults.ROBOT_MOVES)
}


def first_step(message: Message) -> Optional[Message]:
    """Return what to do first, and to keep away from what may move; None: nothing.

    Of a fault that this version does not know, the remedy need not say to keep away.
    """
    remedy = message.remedy
    if remedy in _HANDS_OFF or not message.may_move:
        return remedy
    return Message("Keep your hands clear: the robot may still move. {remedy}", remedy=remedy)


_ASKING = (JobLevel.PAUSED, JobLevel.ATTENTION, JobLevel.FAULT)


@dataclass(frozen=True)
class Condition:
    """What the band says: a level, the state in a word or two, and all of it with its fault."""

    level: JobLevel
    title: Message
    message: Message

    @property
    def remedy(self) -> Optional[Message]:
        return first_step(self.message)

    @property
    def asked(self) -> Optional[Message]:
        """What a person has to do now; None: nothing."""
        return self.remedy if self.level in _ASKING else None


MOVES = Message("ROBOT MOVES")
NO_CONTACT = Message("NO CONTACT")
_CONTROL = "main_control"
_SURVEY = ("", _CONTROL)
# An axis says that it rests up to this time [s] after the main control has seen it.
REPORT_S = 0.5
# The main control reports twice a second; after this time [s] its last word may be out of date.
CONTROL_LATE_S = 2.5
# So long [s] a state lasts without a motion, a trace or a new state: a sweep of a slow analyzer
# takes less. The main control says much earlier which part it waits for: this finds a main
# control that waits for nothing.
STILL_S = 60.0


class _Usual(NamedTuple):
    """How it goes in a state, and who moves the axes for the survey."""

    level: JobLevel
    movers: Tuple[str, ...] = ()


_USUAL: Dict[Optional[SurveyState], _Usual] = {
    # An axis that still slows down when a check begins.
    SurveyState.CHECKING: _Usual(JobLevel.WORKING, (_CONTROL,)),
    SurveyState.HOMING: _Usual(JobLevel.WORKING, _SURVEY),
    SurveyState.SURVEYING: _Usual(JobLevel.WORKING, _SURVEY),
    SurveyState.PAUSING: _Usual(JobLevel.PAUSED, _SURVEY),
    SurveyState.PAUSED: _Usual(JobLevel.PAUSED),
    SurveyState.STOPPING: _Usual(JobLevel.ATTENTION, _SURVEY),
    SurveyState.FINISHED: _Usual(JobLevel.DONE),
    SurveyState.FAILED: _Usual(JobLevel.FAULT),
}
# Codes of the main control while it waits for a part.
WAITS = (PART_LOST.code, PART_SILENT.code, TAKES_LONG.code)
# Levels of a state that trouble elsewhere does not make better.
_KEPT = (JobLevel.PAUSED, JobLevel.FAULT)


def _usual(snapshot: Snapshot) -> _Usual:
    shown = None if snapshot.state is None else snapshot.state.shown
    return _USUAL.get(shown, _Usual(JobLevel.REST))


def condition_of(snapshot: Snapshot) -> Condition:
    """Return what the band shows now: the gravest of what is known."""
    return urgent(snapshot) or _of_state(snapshot)


def urgent(snapshot: Snapshot) -> Optional[Condition]:
    """Return what comes before the state: motion, no contact, a lost survey; None: nothing."""
    if snapshot.replay:
        message = Message("Waiting for a recording.")
        if snapshot.state is not None:
            state = snapshot.state.shown.label
            message = Message("A recorded survey, and no robot: {state}", state=state)
        return Condition(JobLevel.REPLAY, snapshot.replay.title, message)
    return _motion(snapshot) or lost(snapshot)


def lost(snapshot: Snapshot) -> Optional[Condition]:
    """Return what is lost: the contact with the robot, or a survey; None: neither."""
    return _no_contact(snapshot) or _interrupted(snapshot)


def _motion(snapshot: Snapshot) -> Optional[Condition]:
    """Return what moves although no survey moves it.

    An axis that fell silent while it moved still counts: nobody knows that it rests.
    """
    said = [_axis(one) for one in snapshot.moving if not _is_survey(snapshot, one)]
    if not said:
        return None
    if snapshot.service is not None:
        said.append(Message("in service: {activity}", activity=snapshot.service))
    motion = in_a_row(said)
    gone = lost(snapshot)
    if gone is not None:
        motion = Message("{motion}. {alarm}", motion=motion, alarm=gone.message)
    failed = gone is not None or (snapshot.state is not None and snapshot.state.is_fault)
    level = JobLevel.FAULT if failed else JobLevel.ATTENTION
    return Condition(level, MOVES, motion.reporting_only(faults.ROBOT_MOVES))


def _is_survey(snapshot: Snapshot, axis: AxisReport) -> bool:
    """Return whether it is the survey in progress that moves an axis."""
    if not snapshot.control_alive or axis.silent:
        return False
    if _name(axis) == _CONTROL and snapshot.state_s < REPORT_S:
        return True
    return _name(axis) in _usual(snapshot).movers


def _axis(axis: AxisReport) -> Message:
    name = axis.axis.value
    if axis.silent:
        return Message("{axis} axis: no report since it moved", axis=name)
    if not axis.owner:
        return Message("{axis} axis", axis=name)
    return Message("{axis} axis, by {owner}", axis=name, owner=_name(axis))


def _name(axis: AxisReport) -> str:
    return axis.owner.rpartition("/")[2]


def _no_contact(snapshot: Snapshot) -> Optional[Condition]:
    if not snapshot.master_alive:
        message = Message(
            "The ROS master does not answer: the robot may still move. Waiting for it."
        ).with_fault(MASTER_LOST)
    elif snapshot.control_silent_s is None:
        message = Message(
            "No contact with the main control. Start it with: roslaunch gpr20 survey.launch"
        ).with_fault(NOT_RUNNING)
    elif not snapshot.control_alive:
        message = Message(
            "No contact with the main control for {seconds} s: the robot may still move. "
            "Waiting for it.",
            seconds=int(snapshot.control_silent_s),
        ).with_fault(PART_LOST)
    else:
        return None
    return Condition(JobLevel.FAULT, NO_CONTACT, message)


def _interrupted(snapshot: Snapshot) -> Optional[Condition]:
    if not snapshot.interrupted:
        return None
    rests = {one.axis for one in snapshot.axes if not one.moving and not one.silent}
    fault = CAN_RESUME if len(rests) == len(AxisId) else PART_LOST
    message = Message(
        "The main control was restarted. When every axis rests, resume the survey on SURVEY."
    ).with_fault(fault)
    return Condition(JobLevel.FAULT, Message("INTERRUPTED"), message)


def _of_state(snapshot: Snapshot) -> Condition:
    """Return what the state says, or what contradicts it."""
    state, percent = snapshot.state, percent_of(snapshot)
    level = _usual(snapshot).level
    title, message = NO_CONTACT, Message("Waiting for the robot.")
    if state is not None:
        title, message = state.shown.label, state.message
    if percent is not None:
        title = Message("{state} {percent} %", state=title, percent=percent)
    if state is not None and state.is_fault:
        level = JobLevel.PAUSED if state.code is SurveyState.PAUSED else JobLevel.FAULT
        return Condition(level, title, state.reason)
    if snapshot.service is not None:
        message = Message("In progress: {activity}", activity=snapshot.service)
        return Condition(JobLevel.ATTENTION, Message("SERVICE"), message)
    doubt = next(_doubts(snapshot), None)
    if doubt is None:
        return Condition(level, title, message)
    return Condition(level if level in _KEPT else JobLevel.ATTENTION, title, doubt)


def _doubts(snapshot: Snapshot) -> Iterator[Message]:
    """Yield what makes a state doubtful, the most important first."""
    if Request.STOP in snapshot.pending and snapshot.code is not SurveyState.STOPPING:
        # Its answer usually comes within 0.1 s.
        yield Message("STOP was pressed: the axes stop. The main control has not answered yet.")
    silent_s = snapshot.control_silent_s
    if silent_s is not None and silent_s > CONTROL_LATE_S:
        yield Message(
            "No message from the main control for {seconds} s.", seconds=int(silent_s)
        ).with_fault(TAKES_LONG)
    if snapshot.health.trouble is not None:
        yield snapshot.health.trouble
    said = None if snapshot.state is None else snapshot.state.message
    if said is not None and said.severity not in (None, Severity.NOTE):
        yield said
    if _usual(snapshot).movers and snapshot.still_s > STILL_S:
        yield Message("No progress for {seconds} s.", seconds=int(snapshot.still_s)).with_fault(
            faults.STANDS_STILL
        )


def left_of(snapshot: Snapshot) -> Optional[Message]:
    """Return how long the survey still takes; None while something holds it up."""
    progress, state = progress_of(snapshot), snapshot.state
    if progress is None or state is None or urgent(snapshot) is not None:
        return None
    if progress.visited_points >= progress.total_points:
        return None
    if not _usual(snapshot).movers or state.code is SurveyState.STOPPING:
        return None
    # A warning holds up nothing, unless it says what the survey waits for.
    waits = any(one.code in WAITS for one in state.message.faults)
    if any(waits or one is not state.message for one in _doubts(snapshot)):
        return None
    return time_left(progress.remaining_s)
