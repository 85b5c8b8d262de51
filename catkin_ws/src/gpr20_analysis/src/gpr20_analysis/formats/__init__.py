"""File formats; each module writes one, reads it, or both."""
