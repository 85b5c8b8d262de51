"""Files, programs and processes of the system."""
