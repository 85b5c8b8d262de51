"""Driver of one axis of the positioner."""
