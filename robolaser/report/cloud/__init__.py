"""A cloud of points for people: a few lines on the terminal, and a page."""

from robolaser.report.cloud.page import page, print_cloud

__all__ = ["page", "print_cloud"]
