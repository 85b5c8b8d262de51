"""The CONTROL tab: parameters, what the survey will be, START and PAUSE."""
