"""Durable storage of the traces of a GPR-20 survey."""
