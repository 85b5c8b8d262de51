"""The replay on ROS topics; the only part of the analysis that uses ROS."""
