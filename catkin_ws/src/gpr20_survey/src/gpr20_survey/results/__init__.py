"""What was found in a survey and is known about it, as records and as messages; no ROS, no Qt."""
