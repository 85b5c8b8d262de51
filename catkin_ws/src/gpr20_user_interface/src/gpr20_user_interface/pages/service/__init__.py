"""SERVICE: what is wrong with the robot, and its maintenance."""
