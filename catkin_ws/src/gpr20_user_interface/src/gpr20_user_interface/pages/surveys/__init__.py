"""The stored surveys."""
