"""ROBOT: what is wrong with the robot, its parts, and its maintenance."""
