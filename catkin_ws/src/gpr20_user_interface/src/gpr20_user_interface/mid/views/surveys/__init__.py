"""The list of past surveys."""
