"""Drivers of a cell's arm and camera, and recordings with them. Importing opens nothing."""
