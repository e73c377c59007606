"""What a person sees of a result: one self-contained page, and a few lines on the terminal."""

from robolaser.report.page import page, write_report
from robolaser.report.terminal import print_summary

__all__ = ["page", "print_summary", "write_report"]
