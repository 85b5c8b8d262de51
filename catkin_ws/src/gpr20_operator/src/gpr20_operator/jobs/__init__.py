"""What takes a while: focused images, the result of a survey, exports."""
