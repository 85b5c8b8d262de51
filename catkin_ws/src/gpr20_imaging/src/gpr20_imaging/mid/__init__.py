"""The behaviour, without ROS."""
