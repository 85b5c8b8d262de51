"""ROS wiring of the window and of the terminal client."""
