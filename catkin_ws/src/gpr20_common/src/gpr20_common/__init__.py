"""What every GPR-20 package needs and none should write twice."""

__version__ = "0.2.0"
