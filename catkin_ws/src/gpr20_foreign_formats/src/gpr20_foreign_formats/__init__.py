"""Files of other radars and programs."""

__version__ = "0.2.0"
