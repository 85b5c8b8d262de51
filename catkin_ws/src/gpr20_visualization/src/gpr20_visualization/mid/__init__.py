"""What is shown, without ROS."""
