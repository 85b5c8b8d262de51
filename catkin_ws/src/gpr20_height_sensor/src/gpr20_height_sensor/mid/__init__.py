"""From readings of the converter to a height; no ROS."""
