"""`gpr20 view`: a model without Qt, and `views/`, which alone import Qt."""

__version__ = "0.2.0"
