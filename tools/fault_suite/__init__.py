"""Faults of disks and processes, made on purpose: nothing that was acknowledged may be lost."""
