"""A small survey of the simulated robot, to try the commands on."""
