"""The ROS interface of the storage."""
