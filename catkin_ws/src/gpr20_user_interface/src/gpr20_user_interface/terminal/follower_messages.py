"""Why the terminal client stops following a survey, for people."""

from __future__ import annotations

from typing import Optional

from gpr20_common.message import Message
from gpr20_operator import faults
from gpr20_operator.robot.events import ControlState

REPLAY = Message(
    "A replay of a recorded survey is running here, and no robot. Only --attach can follow it. To "
    "use a robot, end the replay and start the robot."
).with_fault(faults.REPLAY_RUNS)


def not_there(wait_s: float) -> Message:
    """Return what the follower says: the main control was never there.

    Args:
        wait_s: How long it waited [s].
    """
    return Message(
        "No contact with the main control within {limit_s:g} s. Start it with `roslaunch gpr20 "
        "survey.launch`. If it is running, check ROS_MASTER_URI and the namespace.",
        limit_s=wait_s,
    ).with_fault(faults.NO_CONTROL)


def lost(silence_s: float) -> Message:
    """Return what the follower says: the main control is silent.

    Args:
        silence_s: For this time [s].
    """
    return Message(
        "No contact with the main control for {limit_s:g} s. The robot may still move. Check that "
        "the main control is running, then follow the survey again with `rosrun "
        "gpr20_user_interface run_survey --attach`.",
        limit_s=silence_s,
    ).with_fault(faults.CONTROL_LOST)


def stop_not_confirmed(stop_s: float, refusal: Optional[Message]) -> Message:
    """Return what the follower says: the survey may not have stopped.

    Args:
        stop_s: How long it waited [s].
        refusal: The last answer to the request; None if there was none.
    """
    if refusal is None:
        return Message(
            "The main control did not confirm within {limit_s:g} s that the survey has stopped. "
            "The robot may still move: switch it off if people are near it.",
            limit_s=stop_s,
        ).with_fault(faults.STOP_UNCONFIRMED)
    return Message(
        "The main control did not confirm within {limit_s:g} s that the survey has stopped; its "
        "last answer to the stop request: {answer}. The robot may still move: switch it off if "
        "people are near it.",
        limit_s=stop_s,
        answer=refusal,
    ).with_fault(faults.STOP_UNCONFIRMED)


def replaced(survey_id: str, state: ControlState) -> Message:
    """Return what the follower says: the main control does not know the survey any more.

    Args:
        survey_id: The survey that was followed.
        state: What the main control reports instead.
    """
    return Message(
        "The main control no longer knows survey {survey}; it may have been restarted. The "
        "traces measured so far are in the survey's folder. The main control is {state}: "
        "{message}",
        survey=survey_id,
        state=state.code.label,
        message=state.message,
    ).with_fault(faults.CONTROL_RESTARTED)
