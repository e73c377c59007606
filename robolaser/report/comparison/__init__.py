"""What a person sees of a comparison: one self-contained page, and twenty lines on the terminal."""

from robolaser.report.comparison.page import document, page
from robolaser.report.comparison.terminal import print_comparison

__all__ = ["document", "page", "print_comparison"]
