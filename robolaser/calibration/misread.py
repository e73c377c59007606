"""Data that do not mean what they say: read otherwise, they fit far better."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import final

import numpy as np

from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.calibration.other_readings import other_arms, read_otherwise
from robolaser.calibration.result import rms
from robolaser.calibration.slipped_rows import short_fit, slipped
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly, rows_of_each, subsampled
from robolaser.estimation.multistart import SEARCH_POINTS
from robolaser.model.forward_model import Model

FALLS = 5.0
"""Factor by which another reading of the joints must lower the error before it is said. A judgement: exchanged columns
leave centimetres or more, the largest effects of the library millimetres."""
MOST_POSES, ROWS_OF_A_POSE = 40, 8  # a camera whose lens is unknown is found from six corners an image and more
BEST = 3.0  # factor by which the error of any other hypothesis must be larger: else it is not known what is wrong
OTHER_ARM_RMS_M = 2e-3
"""Error above which another arm of the same joints is tried. A judgement: effects leave less, as a rule; generations of
an arm differ by centimetres."""


@final
@dataclass(frozen=True)
class Misread:
    """Data that fit far better when they are read otherwise."""

    sentence: str
    shift: int  # by how many poses the rows of points.csv are off; 0 where something else is wrong


def misread(model: Model, rms_m: float) -> Misread | None:
    """What seems to be read wrongly; None where the error is no sign of it, or nothing explains it.

    Each hypothesis is fitted to some rows from its own start values, in a few steps.

    Args:
        model: Data and effects.
        rms_m: Root-mean-square error of the fitted points; infinite where there is no fit.
    """
    return None if rms_m < OTHER_ARM_RMS_M else _tried(model, in_every_way=rms_m >= SETUP_RMS_M)


@lru_cache(maxsize=1)
def _tried(model: Model, *, in_every_way: bool) -> Misread | None:
    """The same of a large error; the last answer is kept, since a diagnosis asks what its calibration has asked."""
    few = _some(model.dataset)
    readings = [*other_arms(few), *((*read_otherwise(few), *slipped(few)) if in_every_way else ())]
    if not readings:
        return None
    as_read = _error(few)
    errors = np.array([_error(reading.dataset) for reading in readings])
    order = np.argsort(errors)
    found, best = readings[int(order[0])], errors[order[0]]
    is_alike = np.array([one is found or (found.alike != "" and one.alike == found.alike) for one in readings])
    second = errors[~is_alike].min(initial=np.inf)
    if not np.isfinite(best) or best * FALLS > as_read or best * BEST > second:
        return None
    instead = f" instead of {_millimetres(as_read)}" if np.isfinite(as_read) else ""
    fault, *others = dict.fromkeys(readings[i].fault for i in np.flatnonzero(is_alike).tolist())
    either = "".join(f", or {other[0].lower()}{other[1:]}" for other in others)
    where = "one of the two" if others else found.where
    return Misread(
        f"{fault}{either}: with that corrected, the error is {_millimetres(best)}{instead}. Correct {where}.",
        found.shift,
    )


def _some(dataset: Dataset) -> Dataset:
    """Rows enough to tell readings apart; of poses that see a whole target, as many of each as place it."""
    if dataset.format.named_points:
        return subsampled(dataset, SEARCH_POINTS)
    poses = np.unique(dataset.points.pose)
    rows = np.flatnonzero(np.isin(dataset.points.pose, poses[evenly(len(poses), MOST_POSES)]))
    return replace(dataset, points=dataset.points.take(rows[rows_of_each(dataset.points.pose[rows], ROWS_OF_A_POSE)]))


def _error(dataset: Dataset) -> float:
    """Root-mean-square error of the points after a short fit [m]; infinite where there is none."""
    if (found := short_fit(dataset)) is None:
        return np.inf
    model, x = found
    error = rms(model.in_metres(x, model.residuals(x[None])[0]))
    return error if np.isfinite(error) else np.inf


def _millimetres(length_m: float) -> str:
    return f"{1e3 * length_m:.0f} mm" if length_m >= 0.01 else f"{1e3 * length_m:.2g} mm"
