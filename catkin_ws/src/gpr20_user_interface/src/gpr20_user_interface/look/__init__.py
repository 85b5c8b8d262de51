"""Colours, sizes and language of the window."""
