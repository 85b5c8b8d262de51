"""The operator's side of a survey: a window and a terminal client."""
