"""The pins that an axis is wired to."""
