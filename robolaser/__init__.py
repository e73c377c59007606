"""robolaser: calibrate robot-mounted laser scanners, and say why the robot does not do what the model says."""
