"""Files of other radars and programs, and the imaging methods of the GPR-20 group."""

__version__ = "0.2.0"
