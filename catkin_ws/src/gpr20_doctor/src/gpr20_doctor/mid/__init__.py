"""Facts about the robot and its computers, and the findings that follow from them."""
