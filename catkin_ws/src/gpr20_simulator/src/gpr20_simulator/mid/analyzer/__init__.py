"""The simulated vector network analyzer: its settings, sweeps, memory, answers and faults."""
