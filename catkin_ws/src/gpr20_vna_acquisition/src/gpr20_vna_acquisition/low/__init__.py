"""External things of the network analyzer: its VXI-11 link."""
