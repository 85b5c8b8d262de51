"""Files, the disk and the revision of the software."""
