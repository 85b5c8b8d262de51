"""External things: the terminal and the signals of the process, files with what it remembers."""
