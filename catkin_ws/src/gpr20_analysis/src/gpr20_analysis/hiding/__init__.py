"""Where a mine could hide: which synthetic targets the detector finds in a survey's own data."""
