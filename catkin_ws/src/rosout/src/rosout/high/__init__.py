"""The ROS interface of the log."""
