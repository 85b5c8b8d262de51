"""Durable storage of the traces of a GPR-20 survey."""

__version__ = "0.1.0"
