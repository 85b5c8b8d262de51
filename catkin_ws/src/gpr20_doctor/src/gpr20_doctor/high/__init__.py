"""The program, and what the graph tells it."""
