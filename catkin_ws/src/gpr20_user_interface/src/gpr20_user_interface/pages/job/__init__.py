"""The survey that runs, or ran last."""
