"""Rigid motions, robots and their kinematics, the camera and the laser plane."""
