"""Why the robot in the cell does not do what the model says: where the gap lies, what causes it, how far it shrinks."""

from robolaser.diagnosis.pipeline import examine
from robolaser.diagnosis.result import Diagnosis

__all__ = ["Diagnosis", "examine"]
