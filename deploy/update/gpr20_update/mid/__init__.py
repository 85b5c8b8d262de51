"""Bundles, packages, the robot, backups: each by itself."""
