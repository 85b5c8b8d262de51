"""An action server that does not depend on the time of day."""

from __future__ import annotations

import actionlib
import rospy


class GoalServer(actionlib.SimpleActionServer):
    """Takes goals in the order in which they come.

    actionlib refuses a goal whose time stamp lies before that of the last one. A stamp is the
    time of day at the client: after its clock was set back by an hour, every goal of the next
    hour would be refused.
    """

    def internal_goal_callback(self, goal: actionlib.ServerGoalHandle) -> None:
        """Take a new goal, whatever its stamp says; it replaces the one before."""
        goal.get_goal_id().stamp = rospy.Time()
        super().internal_goal_callback(goal)
