"""Formats of others: each module writes one, reads it, or both."""
