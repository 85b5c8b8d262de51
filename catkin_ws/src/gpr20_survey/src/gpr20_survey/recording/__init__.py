"""Writing and reading of the ROS bag and the MCAP file of a survey."""
