"""Radar lines and areas computed by Maxwell's equations: another physics than the imaging's."""
