"""What a survey will do: parameters, points, time and space, states, coverage."""
