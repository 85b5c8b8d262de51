"""The plan of the next survey."""
