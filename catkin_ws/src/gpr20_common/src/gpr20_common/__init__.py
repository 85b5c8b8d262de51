"""What every GPR-20 package needs and none should write twice."""
