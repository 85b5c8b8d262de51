"""The devices of the robot as the control sees them: axes, sensors, analyzer, nodes."""
