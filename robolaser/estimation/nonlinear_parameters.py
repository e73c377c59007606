"""Start values of effects with nonlinear parameters: a frequency, a moment, a time constant.

In such a parameter the cost has many local minima, or steps. So all candidate values are tried, with the model
linearized in everything else; the fit continues from the best.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.estimation.fisher_information import NULL, lengths
from robolaser.estimation.linearization import Linearization
from robolaser.estimation.problem import Problem
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model

AGAIN = 2  # times that several effects choose in turn: the first may have explained another's part
NEGLIGIBLE = 1e-8
"""Share of a column's squared length below which it is a combination of others, or imitated by the fitted parameters:
half of double precision."""
CANDIDATES = 1000  # evaluated at a time: a long grid would fill the memory


@final
@dataclass(frozen=True, eq=False)
class GridPoint:
    """A value of an effect's nonlinear parameters, and the best amplitudes with it."""

    nonlinear: Array  # the nonlinear parameters, (s,)
    amplitudes: Array  # the linear parameters that go with it, (q,)
    columns: Array  # residuals by its amplitudes, (K, q)
    gain: float  # decrease of the cost in the linearized model


def with_nonlinear_grid(model: Model) -> tuple[CandidateEffect, ...]:
    """The effects in a model with more than one value of their nonlinear parameters to try."""
    return tuple(one for one in model.effects if len(one.effect.grid(model.dataset, one.where)) > 1)


def initialize_effects(plain: Model, x: Array, effects: Sequence[CandidateEffect]) -> dict[str, float]:
    """Choose the nonlinear parameters of effects that a plain model lacks, and amplitudes to start a fit from, by name.

    From the plain model's optimum x (d,).
    """
    at = Linearization(Problem.of(plain), x)
    known = _basis(at.slopes)
    alone = {one: _best(at, one, known) for one in effects}
    order = sorted(effects, key=lambda one: -alone[one].gain)
    chosen = {order[0]: alone[order[0]]}
    for effect in (order * AGAIN)[1:] if len(order) > 1 else ():
        others = [choice.columns for one, choice in chosen.items() if one is not effect]
        chosen[effect] = _best(at, effect, _basis(np.hstack([at.slopes, *others])))
    return {
        name: float(value)
        for one, choice in chosen.items()
        for name, value in zip(one.parameters.names, [*choice.amplitudes, *choice.nonlinear], strict=True)
    }


def _best(at: Linearization, effect: CandidateEffect, Q: Array) -> GridPoint:
    """The value of the grid that lowers the cost most, beyond a basis (K, n) of known columns."""
    grid = effect.effect.grid(at.problem.model.dataset, effect.where)
    rest = at.white - Q @ (Q.T @ at.white)
    parts = np.array_split(grid, -(-len(grid) * len(effect.effect.amplitudes()) // CANDIDATES))
    choices = [_best_of(at.columns(effect, part), part, effect, rest, Q) for part in parts]
    return max(choices, key=lambda choice: choice.gain)


def _best_of(columns: Array, grid: Array, effect: CandidateEffect, rest: Array, Q: Array) -> GridPoint:
    lower, bound = np.array([(amplitude.lower, amplitude.bound) for amplitude in effect.effect.amplitudes()]).T
    scaled = columns * bound
    imitated = Q.T @ scaled
    whole = np.swapaxes(scaled, 1, 2) @ scaled
    A = whole - np.swapaxes(imitated, 1, 2) @ imitated
    size = np.einsum("gkk->gk", whole)
    A += np.eye(A.shape[1]) * np.where(size > 0, NEGLIGIBLE * size, 1.0)[:, None, :]
    b = np.swapaxes(scaled, 1, 2) @ rest
    share = np.clip(-np.linalg.solve(A, b[..., None])[..., 0], lower / bound, 1.0)
    gains = -2.0 * (share * b).sum(axis=1) - np.einsum("gk,gkl,gl->g", share, A, share)
    i = int(np.argmax(gains))
    return GridPoint(grid[i], share[i] * bound, columns[i], float(gains[i]))


def _basis(columns: Array) -> Array:
    """Orthonormal basis of the range of columns (K, d), (K, n)."""
    U, s, _ = np.linalg.svd(columns / lengths(columns), full_matrices=False)
    return U[:, s > NULL * s.max(initial=0.0)]
