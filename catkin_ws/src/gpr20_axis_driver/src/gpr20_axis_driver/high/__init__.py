"""The ROS interface of an axis."""
