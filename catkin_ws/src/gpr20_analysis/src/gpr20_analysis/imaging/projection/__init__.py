"""Back projection: each cell of the image sums the echoes at its own delays."""
