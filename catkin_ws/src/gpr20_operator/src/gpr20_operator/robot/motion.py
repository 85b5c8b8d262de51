"""Motion that no survey explains: a goal from a terminal, maintenance, another program."""

from __future__ import annotations

from typing import Optional

from gpr20_common.message import Message, in_a_row
from gpr20_operator import faults
from gpr20_operator.robot.events import AxisReport
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_survey.plan.survey_state import SurveyState

TITLE = Message("ROBOT MOVES")
# In these the survey moves the robot, and the band says so by its colour.
_MOVED_BY_SURVEY = (
    SurveyState.HOMING,
    SurveyState.SURVEYING,
    SurveyState.PAUSING,
    SurveyState.STOPPING,
)
_CONTROL = "main_control"


def motion_of(snapshot: Snapshot) -> Optional[Message]:
    """Return what moves although no survey moves it; None: nothing does.

    An axis that fell silent while it moved still counts: nobody knows that it rests.
    """
    if snapshot.replay is not None:
        return None
    moving = [one for one in snapshot.axes if one.moving and not _is_survey(snapshot, one)]
    if not moving:
        return None
    said = [_axis(one) for one in moving]
    if snapshot.service is not None:
        said.append(Message("in service: {activity}", activity=snapshot.service))
    motion = in_a_row(said)
    if snapshot.alarm is not None:
        motion = Message("{motion}. {alarm}", motion=motion, alarm=snapshot.alarm.message)
    return motion.with_fault(faults.ROBOT_MOVES)


def _is_survey(snapshot: Snapshot, axis: AxisReport) -> bool:
    """Return whether it is the survey in progress that moves an axis."""
    state = snapshot.state
    if state is None or state.code not in _MOVED_BY_SURVEY or not snapshot.control_alive:
        return False
    return _name(axis) in ("", _CONTROL)


def _axis(axis: AxisReport) -> Message:
    if not axis.owner:
        return Message("{axis} axis", axis=axis.axis.value)
    return Message("{axis} axis, by {owner}", axis=axis.axis.value, owner=_name(axis))


def _name(axis: AxisReport) -> str:
    return axis.owner.rpartition("/")[2]
