"""The ROS wiring that every node shares."""
