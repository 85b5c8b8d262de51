"""The operator's page of the robot at a distance."""
