"""Reading and checking surveys as they were recorded."""
