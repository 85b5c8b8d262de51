"""How the simulated robot and its surroundings behave; no ROS."""
