"""What a person sees of a calibration: one self-contained page, and a few lines on the terminal."""

from robolaser.report.calibration.page import document, page, print_summary

__all__ = ["document", "page", "print_summary"]
