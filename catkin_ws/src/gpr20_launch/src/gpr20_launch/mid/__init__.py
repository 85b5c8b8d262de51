"""What a configuration is, and what a launch may start."""
