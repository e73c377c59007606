"""Rigid motions, the camera and the laser plane; robots described as text."""
