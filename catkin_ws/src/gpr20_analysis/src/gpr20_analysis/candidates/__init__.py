"""Places in the ground that an operator should look at: found, rated, and written to files."""
