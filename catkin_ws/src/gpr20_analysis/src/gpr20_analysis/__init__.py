"""Offline reading and checking of GPR-20 surveys, without ROS."""

__version__ = "0.1.0"
