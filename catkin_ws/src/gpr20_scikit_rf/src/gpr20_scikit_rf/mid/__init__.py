"""What it takes to get one fresh sweep from these instruments; no ROS."""
