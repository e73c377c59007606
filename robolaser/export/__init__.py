"""A calibration as files for others: URDF, ROS, MuJoCo, Gazebo, and a program without dependencies."""
