"""The polish on all rows: by plain squares, or again and again by weights and a loss that rest on what it left over."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.subsampling import some_of_each
from robolaser.estimation.problem import Box, Residuals
from robolaser.estimation.robust_loss import Loss
from robolaser.model.forward_model import Model
from robolaser.model.noise import noise_of
from robolaser.model.pose_blocks import with_rows

ROUNDS = 3  # weights depend on the estimate; a fourth round changes nothing any more

FEWER, CROWD = 20_000, 4
"""Rows to polish on first where there are so many times more: from there on the steps on all rows are few."""
COARSE = 1e-9  # tolerance of that


def polished(model: Model, box: Box, x: Array, *, weights: str, loss: str) -> tuple[Residuals, Array, int]:
    """Polish from a good start.

    Args:
        model: All rows.
        box: Where the polish may go.
        x: The start, (d,).
        weights: "plain", or "noise" to whiten by the covariance of the noise.
        loss: "square", or one that lets gross errors count for less, by a scale from the residuals.

    Returns:
        The residuals that were minimised last, the optimum (d,), and the candidates evaluated.

    Raises:
        LossUnknown: There is no loss of that name.
    """
    Loss(loss)
    evaluations = 0
    if len(model.dataset.points) > CROWD * FEWER:
        of_pose = model.dataset.points.pose
        table = some_of_each(of_pose, max(1, FEWER // len(np.unique(of_pose))))
        fewer = box.polish(Residuals(with_rows(model, np.sort(table[table >= 0]))), x, tol=COARSE)
        x, evaluations = fewer.x, fewer.evaluations
    residuals = Residuals(model)
    end = box.polish(residuals, x)
    evaluations += end.evaluations
    for _ in range(ROUNDS if weights == "noise" or loss != "square" else 0):
        trusted = residuals.trusted(end.x)
        noise = noise_of(model, end.x, trusted).for_weights() if weights == "noise" else None
        white = Residuals(model, noise)(end.x[None])
        residuals = Residuals(model, noise, Loss.fitting(loss, white.reshape(-1, 3)))
        end = box.polish(residuals, end.x)
        evaluations += end.evaluations
    return residuals, end.x, evaluations


def gross(residuals: Residuals, x: Array) -> list[str]:
    """A warning where a loss lets rows count for less than a half."""
    doubted = int(np.count_nonzero(~residuals.trusted(x)))
    if not doubted:
        return []
    rows = len(residuals.model.dataset.points)
    return [
        f"{doubted} of {rows} points lie so far off that they count for less than half ({residuals.loss.name} loss)."
    ]
