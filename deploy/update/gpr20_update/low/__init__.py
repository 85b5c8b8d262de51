"""Files, programs and locks of the system."""
