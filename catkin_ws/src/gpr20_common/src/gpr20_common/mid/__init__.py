"""Behaviour that every package shares; no ROS."""
