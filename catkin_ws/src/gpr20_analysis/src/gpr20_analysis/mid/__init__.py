"""What the checks do; no ROS."""
