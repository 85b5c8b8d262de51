"""The ROS interface of the simulated robot."""
