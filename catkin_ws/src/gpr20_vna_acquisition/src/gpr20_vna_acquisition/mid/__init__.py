"""What it takes to get one fresh sweep from the instrument; no ROS."""
