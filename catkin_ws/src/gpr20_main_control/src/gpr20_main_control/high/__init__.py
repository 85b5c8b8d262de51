"""The ROS interface of the survey."""
