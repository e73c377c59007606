"""Measurement errors in residuals."""
