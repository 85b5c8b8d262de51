"""The ROS interface of an operator's screen: topics as events, and requests."""
