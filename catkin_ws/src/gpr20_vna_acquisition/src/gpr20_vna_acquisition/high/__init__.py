"""The ROS interface of the network analyzer."""
