"""The plan of the next survey: its fields, figures, names and profiles."""
