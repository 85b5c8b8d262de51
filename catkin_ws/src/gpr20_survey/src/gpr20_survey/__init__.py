"""What a GPR-20 survey is: parameters, plan, traces, folder and recordings; without ROS and Qt."""
