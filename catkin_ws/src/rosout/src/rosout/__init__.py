"""The log of all nodes, heard on loopback alone."""
