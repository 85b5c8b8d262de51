"""The steps of an update, and the command."""
