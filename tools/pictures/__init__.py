"""The pictures of the documentation, made from surveys of the simulated robot."""
