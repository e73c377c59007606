"""A calibrated arm for simulators: MJCF, SDF, and a program without dependencies."""
