"""The robot and its survey in standard ROS messages."""
