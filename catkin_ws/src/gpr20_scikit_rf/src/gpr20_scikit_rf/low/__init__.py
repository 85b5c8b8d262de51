"""External things of these analyzers: their VISA sessions."""
