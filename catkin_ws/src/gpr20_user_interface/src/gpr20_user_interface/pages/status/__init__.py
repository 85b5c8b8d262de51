"""STATUS: the robot and its parts."""
