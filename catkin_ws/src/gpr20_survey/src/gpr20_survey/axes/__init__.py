"""The axes of the positioner: their names, parameters and speed."""
