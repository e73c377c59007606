"""What a person sees of a comparison: one self-contained page, and twenty lines on the terminal."""

from robolaser.report.comparison.page import page
from robolaser.report.comparison.terminal import print_comparison

__all__ = ["page", "print_comparison"]
