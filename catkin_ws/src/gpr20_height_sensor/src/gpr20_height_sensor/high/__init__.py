"""The ROS interface of the height sensor."""
