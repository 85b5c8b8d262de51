"""The permittivity of the ground, estimated from the echoes of what is buried."""
