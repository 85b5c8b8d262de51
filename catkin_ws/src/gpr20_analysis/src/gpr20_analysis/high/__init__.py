"""The replay onto ROS topics; the only part of the analysis that knows ROS."""
