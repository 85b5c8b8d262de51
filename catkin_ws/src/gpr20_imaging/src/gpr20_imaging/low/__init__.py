"""One external thing each."""
