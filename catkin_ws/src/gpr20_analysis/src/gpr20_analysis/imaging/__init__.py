"""From the traces of a survey to an image of the ground."""
