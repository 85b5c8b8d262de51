"""Moments as ROS knows them."""

from __future__ import annotations

import rospy

US_PER_S = 1_000_000
NS_PER_US = 1000


def microseconds(moment: rospy.Time) -> int:
    """Return a moment as whole microseconds since 1970, the rest cut off."""
    return moment.secs * US_PER_S + moment.nsecs // NS_PER_US


def ros_time(time_us: int) -> rospy.Time:
    """Return a moment [microseconds since 1970, UTC] as ROS knows it."""
    seconds, rest_us = divmod(time_us, US_PER_S)
    return rospy.Time(seconds, rest_us * NS_PER_US)
