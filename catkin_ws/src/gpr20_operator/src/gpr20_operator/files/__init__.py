"""Files that the screen keeps on its own computer."""
