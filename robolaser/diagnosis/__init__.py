"""Diagnosis of the gap between a robot and its model: location, causes and remaining size."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robolaser.diagnosis.pipeline import examine
    from robolaser.diagnosis.result import Diagnosis

__all__ = ["Diagnosis", "examine"]


def __getattr__(name: str) -> Any:
    """Load the diagnosis at its first use: a calibration's report needs only its words."""
    if name == "examine":
        from robolaser.diagnosis.pipeline import examine  # noqa: PLC0415

        return examine
    if name == "Diagnosis":
        from robolaser.diagnosis.result import Diagnosis  # noqa: PLC0415

        return Diagnosis
    raise AttributeError(f"module 'robolaser.diagnosis' has no attribute '{name}'")
