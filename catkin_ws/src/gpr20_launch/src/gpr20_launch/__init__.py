"""The robot's configuration files, and the checks before a launch."""
