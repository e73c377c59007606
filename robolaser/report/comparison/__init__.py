"""What a comparison looks like: page, terminal, tables for a paper."""

from robolaser.report.comparison.page import document, page, print_comparison

__all__ = ["document", "page", "print_comparison"]
