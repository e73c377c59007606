"""Why a robot does not do what its model predicts: where the gap is, what causes it, and how far it shrinks."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robolaser.diagnosis.pipeline import examine
    from robolaser.diagnosis.result import Diagnosis

__all__ = ["Diagnosis", "examine"]


def __getattr__(name: str) -> Any:
    """Load the diagnosis when it is first used: a calibration's report takes only its words."""
    if name == "examine":
        from robolaser.diagnosis.pipeline import examine  # noqa: PLC0415

        return examine
    if name == "Diagnosis":
        from robolaser.diagnosis.result import Diagnosis  # noqa: PLC0415

        return Diagnosis
    raise AttributeError(f"module 'robolaser.diagnosis' has no attribute '{name}'")
