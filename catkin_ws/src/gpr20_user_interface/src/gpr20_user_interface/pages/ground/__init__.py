"""GROUND: the survey from above, its sections and what belongs to it."""
