"""One survey: its plan, steps, engine, samples, storage, pauses and end."""
