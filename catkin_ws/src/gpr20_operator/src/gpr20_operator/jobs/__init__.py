"""What takes a while: focused images, the search for candidates, exports."""
