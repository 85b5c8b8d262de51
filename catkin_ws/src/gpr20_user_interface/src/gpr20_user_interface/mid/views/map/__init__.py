"""The MAP tab: planned stops and what became of each."""
