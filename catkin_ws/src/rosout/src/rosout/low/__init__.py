"""External things of the log: its file."""
