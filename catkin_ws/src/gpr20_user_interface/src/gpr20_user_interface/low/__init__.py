"""External things: the terminal and the signals of the process."""
