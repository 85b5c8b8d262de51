"""The permittivity of the ground, and how it is known."""
