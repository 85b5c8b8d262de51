"""The interactive viewer: a model without Qt, and `views/`, which alone import Qt."""
