"""Whether an analyzer, its class and the instrument, does what a survey relies on."""
