"""The survey: what is measured, in which order, and what happens when something fails."""
