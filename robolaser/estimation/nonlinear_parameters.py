"""Where to look for what says how an effect acts, and not how much: a frequency, a moment, a time constant.

In such a shape the misfit has many valleys, or steps. So all values worth trying are tried, as far as the model is
linear in everything else; the polish goes on from the best.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.estimation.jacobian import jacobian
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model

STEP = 1e-3
"""Of a derivative by an effect's number, in units of its typical size."""
AGAIN = 2
"""Times that several effects choose in turn: the first to choose may have explained what is another's."""
NULL = 1e-7
"""Singular values of unit columns below this share of the largest move nothing."""
IMITATED = 1e-8
"""Share of a column's square up to which what is left, once what imitates it is taken out, is rounding."""
CANDIDATES = 1000
"""Evaluated at a time: a long grid would fill the memory."""


@final
@dataclass(frozen=True, eq=False)
class Choice:
    """A value of an effect's shapes, and what the effect does with it.

    Attributes:
        shapes: The shapes, (s,).
        numbers: The effect's numbers that go with it, (k,).
        columns: Residuals by its numbers, (3m, k).
        gain: By how much the sum of squares shrinks, as far as the model is linear.
    """

    shapes: Array
    numbers: Array
    columns: Array
    gain: float


def shaped(model: Model) -> tuple[CandidateEffect, ...]:
    """The effects in a model with more than one value of their shapes to try."""
    return tuple(one for one in model.effects if len(one.effect.grid(model.dataset, one.where)) > 1)


def with_shapes(plain: Model, x: Array, candidate_effects: Sequence[CandidateEffect]) -> dict[str, float]:
    """Choose the shapes of effects that a fitted model lacks, and their numbers to start a fit from.

    Args:
        plain: The model without them.
        x: Its optimum, (d,).
        candidate_effects: The effects.

    Returns:
        Values by the names of the effects' parameters.
    """
    e = plain.residuals(x[None]).reshape(-1)
    known = jacobian(plain, x)
    alone = {one: _best(plain, x, one, e, known) for one in candidate_effects}
    order = sorted(candidate_effects, key=lambda one: -alone[one].gain)
    chosen = {order[0]: alone[order[0]]}
    for candidate_effect in (order * AGAIN)[1:] if len(order) > 1 else ():
        others = [choice.columns for one, choice in chosen.items() if one is not candidate_effect]
        chosen[candidate_effect] = _best(plain, x, candidate_effect, e, np.hstack([known, *others]))
    return {
        name: float(value)
        for one, choice in chosen.items()
        for name, value in zip(one.parameters.names, [*choice.numbers, *choice.shapes], strict=True)
    }


def _best(plain: Model, x: Array, candidate_effect: CandidateEffect, e: Array, known: Array) -> Choice:
    """The value of the grid that lowers the squares of e most, beside what the known columns explain."""
    grid = candidate_effect.effect.grid(plain.dataset, candidate_effect.where)
    k = len(candidate_effect.effect.amplitudes())
    Q = _basis(known)
    rest = e - Q @ (Q.T @ e)
    best: Choice | None = None
    for part in np.array_split(grid, -(-len(grid) * k // CANDIDATES)):
        columns = _columns(plain, x, candidate_effect, part, e)
        choice = _best_of(columns, part, candidate_effect, rest, Q)
        best = choice if best is None or choice.gain > best.gain else best
    assert best is not None  # a grid has at least one value
    return best


def _columns(plain: Model, x: Array, candidate_effect: CandidateEffect, grid: Array, e: Array) -> Array:
    """Residuals by the candidate_effect's numbers for each value of its shapes, (g, 3m, k)."""
    model = plain.with_effects((*plain.effects, candidate_effect))
    step = STEP * np.array([typical for *_, typical in candidate_effect.effect.amplitudes()])
    k = len(step)
    numbers = np.tile(np.diag(step), (len(grid), 1))
    base = np.repeat(x[None], len(numbers), axis=0)
    moved = model.residuals(np.hstack([base, numbers, np.repeat(grid, k, axis=0)]))
    slopes: Array = np.swapaxes(moved.reshape(len(grid), k, -1) - e, 1, 2) / step
    return slopes


def _best_of(columns: Array, grid: Array, candidate_effect: CandidateEffect, rest: Array, Q: Array) -> Choice:
    bound = np.array([bound for _, _, bound, _ in candidate_effect.effect.amplitudes()])
    scaled = columns * bound
    imitated = Q.T @ scaled
    whole = np.swapaxes(scaled, 1, 2) @ scaled
    A = whole - np.swapaxes(imitated, 1, 2) @ imitated
    size = np.einsum("gkk->gk", whole)
    A += np.eye(A.shape[1]) * np.where(size > 0, IMITATED * size, 1.0)[:, None, :]
    b = np.swapaxes(scaled, 1, 2) @ rest
    share = np.clip(-np.linalg.solve(A, b[..., None])[..., 0], -1.0, 1.0)
    gains = -2.0 * (share * b).sum(axis=1) - np.einsum("gk,gkl,gl->g", share, A, share)
    i = int(np.argmax(gains))
    return Choice(grid[i], share[i] * bound, columns[i], float(gains[i]))


def _basis(columns: Array) -> Array:
    """Orthonormal basis of what columns (3m, d) reach, (3m, d')."""
    length = np.linalg.norm(columns, axis=0)
    U, s, _ = np.linalg.svd(columns / np.where(length > 0, length, 1.0), full_matrices=False)
    reached: Array = U[:, s > NULL * s.max(initial=0.0)]
    return reached
