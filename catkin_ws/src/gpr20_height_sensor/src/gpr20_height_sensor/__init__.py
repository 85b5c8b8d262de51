"""Driver of the height sensor."""
