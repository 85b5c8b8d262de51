"""Files and imaging methods of other programs: those of the GPR-20 group, and of gprMax."""

__version__ = "0.2.0"
