"""The simulated GPR-20 robot."""
