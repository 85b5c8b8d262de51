"""The robots that share the ROS master."""
