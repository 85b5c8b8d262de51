"""What an operator's screen needs without Qt and ROS: states, plans, jobs, remedies, words."""
