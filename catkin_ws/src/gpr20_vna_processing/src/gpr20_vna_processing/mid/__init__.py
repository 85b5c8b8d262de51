"""The behaviour of the storage; no ROS."""
