"""MAP and RADAR: the ground from above and in sections."""
