"""The widgets of the window; no ROS, no behaviour of a survey."""
