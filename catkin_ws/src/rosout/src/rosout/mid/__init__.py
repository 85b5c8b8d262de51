"""How an entry of the log reads; no ROS."""
