"""The nodes of a launch."""
