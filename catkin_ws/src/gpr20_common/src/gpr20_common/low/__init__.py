"""External things that every package shares: the clock."""
