"""Calibration: search, fit, result and exports."""
