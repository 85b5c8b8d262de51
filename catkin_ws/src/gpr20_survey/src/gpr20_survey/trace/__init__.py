"""The sweep and the trace, and their JSON and ROS forms."""
