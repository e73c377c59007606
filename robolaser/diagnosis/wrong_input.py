"""Faults of the data set rather than of the cell: their probability, and their place in a diagnosis."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.special import expit, ndtr

from robolaser.arrays import Array
from robolaser.calibration.misread import MISREAD
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.result import Diagnosis, Estimate, WrongInput
from robolaser.diagnosis.thresholds import SIGMA_OF_95_PERCENT
from robolaser.estimation.certainty import LIKELY
from robolaser.model.blocks.errors import moved_with_pose
from robolaser.model.forward_model import Model
from robolaser.model.grouped_rows import GroupedRows
from robolaser.model.sensors.placements import SIX


def mispaired(poses: int, gap_m: float) -> WrongInput:
    """Rows at wrong poses, shifted by `poses` poses or of that many poses; both gaps are reported as the same."""
    parameters = {"poses": Estimate(float(poses), None, "")}
    return WrongInput("mispaired", "image", "measuring_system", MISREAD, parameters, gap_m, gap_m)


def at_other_poses(share: float) -> Localization:
    """The location of the gap by rows at wrong poses."""
    return Localization("image", "order of the poses", share, 0.0, 1.0 - MISREAD, unknown=False)


def squares(observed: Dataset, errors: Array) -> dict[str, float]:
    """Mean squared error of each pose's rows, (m, j) [m²]."""
    poses, number = np.unique(observed.points.pose, return_inverse=True)
    means = np.bincount(number, (errors**2).sum(axis=-1)) / np.bincount(number)
    return {observed.poses.names[pose]: float(mean) for pose, mean in zip(poses, means, strict=True)}


def squares_within(model: Model, x: Array, errors: Array) -> dict[str, float]:
    """The same of rows' errors (m, k), without what a motion of the whole pose explains: all of six numbers."""
    rows = GroupedRows(model.dataset.points.pose)
    moves = rows.apart(np.concatenate(moved_with_pose(model.blocks, *model.at(x)), axis=2))
    own = rows.apart(errors)
    move = np.linalg.pinv(moves.reshape(len(own), -1, moves.shape[3])) @ own.reshape(len(own), -1, 1)
    left = rows.together(own - (moves @ move[:, None])[..., 0])
    numbers = np.bincount(rows.group)[rows.group, None] * errors.shape[1]
    return squares(model.dataset, np.where(numbers > len(SIX), left, 0.0))


def fall_in_sigmas(before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """Decrease of the mean squared error, in its standard errors, over the poses of both."""
    falls = np.array([before[name] - after[name] for name in before if name in after])
    if len(falls) < 2:
        return -np.inf
    return float(falls.mean() / max(falls.std(ddof=1) / np.sqrt(len(falls)), np.finfo(float).tiny))


def probability_of(found: Diagnosis, corrected: Diagnosis, log_odds: float = 0.0) -> float:
    """Probability that the fault, not the effects found with it, is the cause, by held-out likelihoods.

    Each model predicts every row from other poses: the product of these likelihoods is its evidence.

    Args:
        found: The diagnosis of the data set as given.
        corrected: The diagnosis without the fault.
        log_odds: Logarithm of the odds for the fault by what belongs to no pose.
    """
    before, after = squares(found.observed, found.after_m), squares(corrected.observed, corrected.after_m)
    rows = len(corrected.observed.points) / max(1, len(after))
    variance = corrected.gap.after_m**2 / corrected.after_m.shape[-1]
    excess = sum(before[name] - after[name] for name in before if name in after) * rows / (2.0 * variance)
    probability = float(expit(excess + log_odds))
    sure = log_odds > 0.0 or fall_in_sigmas(before, after) > SIGMA_OF_95_PERCENT
    return probability if sure or probability < 0.5 else min(probability, LIKELY)


def with_fault(found: Diagnosis, corrected: Diagnosis, wrong: WrongInput, text: str, coordinate: str) -> Diagnosis:
    """The diagnosis of the corrected data set, reported as one of the given data set.

    Args:
        found: The diagnosis of the data set as given.
        corrected: The diagnosis without the fault.
        wrong: The fault.
        text: The fault as a sentence.
        coordinate: The coordinate of the gap at the location of the fault.
    """
    closed = max(0.0, 1.0 - (wrong.gap_after_m / wrong.gap_before_m) ** 2)
    sigmas = fall_in_sigmas(squares(found.observed, found.before_m), squares(corrected.observed, corrected.after_m))
    location = Localization(wrong.where, coordinate, closed, 0.0, float(2.0 * ndtr(-abs(sigmas))), unknown=False)
    rest = [replace(one, share=one.share * (1.0 - closed)) for one in corrected.where]
    return replace(
        corrected,
        verdict="explained" if corrected.verdict == "no_gap" else corrected.verdict,
        sentence=text if corrected.verdict == "no_gap" else f"{text} {corrected.sentence}",
        gap=replace(corrected.gap, nominal_m=found.gap.nominal_m, calibrated_m=found.gap.calibrated_m),
        where=tuple(sorted((location, *rest), key=lambda one: -one.share)),
        wrong_input=wrong,
        as_given=found.as_given or found.dataset,
    )
