"""Where a polish may go: the bounds, with held parameters closed, and the residuals that it sees."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.estimation.differences import Around
from robolaser.estimation.gauss_newton import SQUARE, Polished, gauss_newton
from robolaser.estimation.robust_loss import AXES, Loss
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel
from robolaser.model.pose_blocks import blocks_of

MOST_STEPS = 3000  # few points leave long bent valleys: 200 steps were needed along one, 20 are usual
HALF = 0.5  # of a row's share: from here on a loss takes it for right rather than wrong


@final
@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals as one row for each candidate, (c, d) -> (c, 3 m), and what they cost.

    Attributes:
        model: Gives them.
        noise: Whitens them, where given.
        loss: What each row's three numbers cost.
    """

    model: Model
    noise: NoiseModel | None = None
    loss: Loss = SQUARE

    def __call__(self, x: Array) -> Array:
        """All rows, three numbers each."""
        return self.whitened(self.model.residuals(x))

    def whitened(self, plain: Array) -> Array:
        """Plain residuals (c, m, 3) as this sees them, (c, 3 m)."""
        rows = plain.reshape(len(plain), -1)
        return rows if self.noise is None else self.noise.whiten(rows)

    def trusted(self, x: Array) -> Bools:
        """Rows that count for half or more with the parameters x (d,), (m,)."""
        trusted = np.ones(len(self.model.dataset.points), dtype=bool)
        for rows, block in self.blocks if self.loss != SQUARE else ():
            trusted[rows] = self.loss.shares(block(x[None]))[0] >= HALF
        return trusted

    @cached_property
    def blocks(self) -> tuple[tuple[Ints, "Residuals"], ...]:
        """The same in blocks of whole poses: numbers of their rows (m,), and their residuals."""
        blocks = blocks_of(self.model)
        if len(blocks) == 1:
            return ((blocks[0].rows, self),)
        noises = (None if self.noise is None else self.noise.of_rows(block.rows) for block in blocks)
        return tuple(
            (block.rows, Residuals(block.model, noise, self.loss)) for block, noise in zip(blocks, noises, strict=True)
        )


@final
@dataclass(frozen=True, eq=False)
class _Some:
    """Some numbers (3m,) of residuals."""

    residuals: Residuals
    kept: Bools

    def __call__(self, x: Array) -> Array:
        return self.residuals(x)[:, self.kept]


@final
@dataclass(frozen=True)
class Box:
    """Bounds of a model's parameters, (d,) each, those of held parameters closed.

    Attributes:
        lower: Lower bounds.
        upper: Upper bounds.
        scale: A typical change of each parameter: the distance of its bounds.
        held: Parameters that the gauge holds at their nominal values.
    """

    lower: Array
    upper: Array
    scale: Array
    held: Bools

    @classmethod
    def of(cls, model: Model) -> "Box":
        """The bounds of the data set, with the gauge fixed."""
        parameters = model.parameters
        held = np.isin(parameters.names, model.sensor.fixed)
        lower = np.where(held, parameters.nominal, parameters.lower)
        upper = np.where(held, parameters.nominal, parameters.upper)
        return cls(lower, upper, parameters.width, held)

    def polish(self, residuals: Residuals, start: Array, *, tol: float = 1e-13, kept: Bools | None = None) -> Polished:
        """Gauss-Newton steps to the nearest optimum, of the rows to be kept (m,) or of all."""
        blocks: list[Callable[[Array], Array]] = []
        for rows, block in residuals.blocks:
            if kept is None or kept[rows].all():
                blocks.append(block)
            elif kept[rows].any():
                blocks.append(_Some(block, np.repeat(kept[rows], AXES)))
        return gauss_newton(
            blocks,
            start,
            self.lower,
            self.upper,
            scale=self.scale,
            loss=residuals.loss,
            tol=tol,
            max_iterations=MOST_STEPS,
        )

    def around(self, x: Array) -> Around:
        """A point within the bounds, for derivatives."""
        return Around(np.clip(x, self.lower, self.upper), self.lower, self.upper, self.scale)

    def on_bound(self, x: Array) -> Bools:
        """Parameters with room that stand on one of their bounds, (d,)."""
        return ~self.held & ((x <= self.lower) | (x >= self.upper))
