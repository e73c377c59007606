"""Faults of files that are visible before a diagnosis, and are reported at import."""

import numpy as np

from robolaser.calibration.misread import Misread, misread
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.summary_text import exchanged
from robolaser.errors import RobolaserError
from robolaser.model.forward_model import Model


def gross_mistakes(dataset: Dataset) -> tuple[str, ...]:
    """Sentences on errors of centimetres that another reading of the files removes, and on exchanged images.

    Args:
        dataset: Has points; no fault is reported if it cannot be calibrated for other reasons.
    """
    try:
        preparation = Preparation.of(dataset, seed=0)
        found, belongs = preparation.misread(), preparation.belongs
    except (RobolaserError, np.linalg.LinAlgError):
        found, belongs = _unfitted(dataset), {}
    sentences = [found.sentence] if found else []
    if belongs:
        sentences.append(f"{exchanged(belongs, dataset.poses.names)}. Correct the data set.")
    return tuple(sentences)


def _unfitted(dataset: Dataset) -> Misread | None:
    try:
        return misread(Model(dataset), np.inf)
    except (RobolaserError, np.linalg.LinAlgError):
        return None
