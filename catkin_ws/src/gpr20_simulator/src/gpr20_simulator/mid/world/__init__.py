"""The simulated ground and air: what is buried, how waves travel, what the sensors see."""
