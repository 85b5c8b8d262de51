"""What operators see and may do; no ROS."""
