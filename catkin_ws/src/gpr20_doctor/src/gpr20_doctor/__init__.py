"""What is wrong with the robot and its computers, and what to do about it."""
