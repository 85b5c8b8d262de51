"""The behaviour of the survey; no ROS."""
