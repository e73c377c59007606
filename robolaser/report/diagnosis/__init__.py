"""What a person sees of a diagnosis: one self-contained page, and twenty lines on the terminal."""

from robolaser.report.diagnosis.page import page
from robolaser.report.diagnosis.terminal import print_diagnosis

__all__ = ["page", "print_diagnosis"]
