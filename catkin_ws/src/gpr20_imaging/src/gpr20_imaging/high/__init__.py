"""The ROS interface."""
