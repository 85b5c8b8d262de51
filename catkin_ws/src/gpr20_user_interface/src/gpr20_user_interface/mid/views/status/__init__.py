"""The STATUS tab: what the robot does and how its parts are."""
