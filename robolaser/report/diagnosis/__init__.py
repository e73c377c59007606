"""What a person sees of a diagnosis: one self-contained page, and twenty lines on the terminal."""

from robolaser.report.diagnosis.page import document, page, print_diagnosis

__all__ = ["document", "page", "print_diagnosis"]
