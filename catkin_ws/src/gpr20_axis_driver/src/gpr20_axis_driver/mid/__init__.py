"""The behaviour of an axis; no ROS."""
