"""Images of the ground from the traces of a survey."""
