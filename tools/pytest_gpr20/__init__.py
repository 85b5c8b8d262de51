"""Plugins of pytest for this project; the conftest.py of the checkout loads them."""
