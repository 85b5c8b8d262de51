"""The program, and what it reads from the graph."""
