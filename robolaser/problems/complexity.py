"""How small a gap can a model of so many effects have? A question with two objectives."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from pymoo.core.problem import Problem
from pymoo.core.repair import Repair

from robolaser.arrays import Array, Bools, Ints
from robolaser.errors import AlgorithmError

IN_THE_MODEL = 0.5  # inclusion number above which an effect is in the model
SEEN = 1e-9  # share of the largest singular value, or eigenvalue, below which the data see nothing of a combination


@final
@dataclass(frozen=True)
class Neighbourhood:
    """A fitted model, and how its residuals change near the optimum, as far as that is linear.

    Examples:
        >>> fitted.plain_slopes.shape  # rows, coordinates, ordinary parameters
        (20, 3, 2)
    """

    white: Array  # whitened residuals, the distances from the priors beneath, (k,)
    white_slopes: Array  # the same by the ordinary parameters, (k, d)
    plain: Array  # residuals, (m, 3) [m]
    plain_slopes: Array  # the same by the ordinary parameters, in the same units, (m, 3, d) [m]
    row: Ints  # to which plain row each whitened one belongs, (k,); -1 for priors, which are never held out


@final
@dataclass(frozen=True)
class Addition:
    """An effect that may be in the model.

    Examples:
        >>> effect.name, effect.plain.shape  # rows, coordinates, amplitudes
        ('roll', (20, 3, 1))
    """

    name: str  # for people
    white: Array  # whitened residuals by its amplitudes, (k, a)
    plain: Array  # residuals by its amplitudes, (m, 3, a) [m]
    reach: Array  # largest amplitudes either way, (a,); also how large they are thought to be beforehand


@final
class GapAgainstComplexity(Problem):
    """Minimise the held-out gap and the number of effects, for a choice of effects and their amplitudes.

    `x` has a number from 0 to 1 for each effect, which is in the model above ½, then all amplitudes, effect by effect,
    within their reach. `F` is the root-mean-square 3-D error [m], each fold of rows predicted by ordinary parameters
    that were fitted to the other folds around the given amplitudes, and the number of effects. Vectorised: the
    ordinary parameters are eliminated beforehand, after which the squared gap is one quadratic form of the amplitudes
    and costs the same for any number of rows.

    Attributes:
        names: Of the effects, n of them.
        effect: To which of them each amplitude belongs, (a,).
        reach: Of each amplitude, (a,).

    Args:
        model: The model without effects.
        additions: Effects, one or more.
        fold: In which each plain row is held out, (m,).

    Raises:
        AlgorithmError: There is no effect, or fewer than two folds.

    Examples:
        >>> from robolaser.problems import GapAgainstComplexity
        >>> problem = GapAgainstComplexity(fitted, [effect], fold=np.arange(20) % 5)
        >>> problem.evaluate(np.array([[0.0, 0.0], [1.0, 0.5]]))[:, 1]  # the number of effects
        array([0., 1.])
    """

    def __init__(self, model: Neighbourhood, additions: Sequence[Addition], fold: Ints) -> None:
        if not additions:
            raise AlgorithmError(f"GapAgainstComplexity: additions is {list(additions)}. Expected: one effect or more.")
        if len(np.unique(fold)) < 2:
            raise AlgorithmError(
                f"GapAgainstComplexity: fold is {np.unique(fold).tolist()}. Expected: two folds or more."
            )
        self.names = tuple(addition.name for addition in additions)
        self.effect = np.repeat(np.arange(len(additions)), [len(addition.reach) for addition in additions])
        self.reach = np.concatenate([addition.reach for addition in additions])
        self._rows = len(fold)
        self._folds = _folds(model, additions, fold, self.reach)
        self._square, self._linear, self._constant = (part.sum(axis=0) for part in self._folds.gap)
        n = len(additions)
        super().__init__(
            n_var=n + len(self.reach),
            n_obj=2,
            xl=np.concatenate([np.zeros(n), -self.reach]),
            xu=np.concatenate([np.ones(n), self.reach]),
            vtype=float,
        )

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        chosen = self.chosen(x)
        amplitudes = np.where(chosen[:, self.effect], x[:, len(self.names) :], 0.0)
        squares = self._constant + ((amplitudes @ self._square + 2.0 * self._linear) * amplitudes).sum(axis=1)
        out["F"] = np.column_stack([self._rms(squares), chosen.sum(axis=1)])

    def _rms(self, squares: Array) -> Array:
        return np.sqrt(np.maximum(squares, 0.0) / self._rows)

    def chosen(self, x: Array) -> Bools:
        """The effects in the model, (c, n_var) -> (c, n)."""
        return x[:, : len(self.names)] > IN_THE_MODEL

    def settled(self, x: Array) -> Array:
        """The same choices with the amplitudes that make their gap smallest, (c, n_var) -> (c, n_var).

        Least squares, held by the reach where the data see nothing; then cut off at the reach.
        """
        spread = self._constant / (3 * self._rows)
        square = self._square + spread * np.diag(self.reach**-2.0)
        amplitudes = _solve(square, -self._linear, self.chosen(x)[:, self.effect])
        return np.hstack([x[:, : len(self.names)], np.clip(amplitudes, -self.reach, self.reach)])

    def unseen(self, chosen: Bools) -> Array:
        """Gaps of choices, (c, n) -> (c,) [m], the amplitudes too fitted to the other folds, and by their noise.

        What a front promises of new poses: amplitudes that were searched for have seen all folds.
        """
        inside = chosen[:, self.effect]
        squares = np.zeros(len(chosen))
        for normal, moment, *gap in zip(*self._folds.normal, *self._folds.gap, strict=True):
            amplitudes = _solve(normal, -moment, inside)
            square, linear, constant = gap
            squares += constant + ((amplitudes @ square + 2.0 * linear) * amplitudes).sum(axis=1)
        return self._rms(squares)


@final
class BestAmplitudes(Repair):
    """Amplitudes put where the gap is smallest, so that a search has only to choose among the effects.

    Examples:
        >>> from pymoo.algorithms.moo.nsga2 import NSGA2
        >>> from robolaser.problems import BestAmplitudes, GapAgainstComplexity
        >>> problem = GapAgainstComplexity(fitted, [effect], fold=np.arange(20) % 5)
        >>> result = minimize(problem, NSGA2(pop_size=20, repair=BestAmplitudes()), ("n_gen", 5), seed=1)
        >>> result.F.shape[1]
        2
    """

    def _do(self, problem: GapAgainstComplexity, X: Array, **kwargs: Any) -> Array:
        return problem.settled(X)


@final
@dataclass(frozen=True)
class _Folds:
    """What is left of all rows without the ordinary parameters: quadratic forms of the amplitudes, for each fold."""

    gap: tuple[Array, Array, Array]  # squared error of the fold as seen from the others: (f, a, a), (f, a), (f,) [m²]
    normal: tuple[Array, Array]  # squared whitened misfit of the others: (f, a, a), (f, a)


def _folds(model: Neighbourhood, additions: Sequence[Addition], fold: Ints, reach: Array) -> _Folds:
    white = np.column_stack([*(addition.white for addition in additions), model.white])
    plain = np.concatenate([*(addition.plain for addition in additions), model.plain[..., None]], axis=-1)
    U, s, Vt = np.linalg.svd(model.white_slopes, full_matrices=False)
    seen = s > SEEN * s.max(initial=0.0)
    Q, turned = U[:, seen], model.plain_slopes @ (Vt[seen].T / s[seen])
    of_white = np.where(model.row < 0, -1, fold[model.row])
    prior = np.diag(np.append(reach**-2.0, 0.0))

    whole = Q.T @ white, white.T @ white
    gaps, normals = [], []
    for k in np.unique(fold):
        out = of_white == k
        own = np.eye(Q.shape[1]) - Q[out].T @ Q[out]
        mixed = whole[0] - Q[out].T @ white[out]
        moves = np.linalg.pinv(own, rcond=SEEN, hermitian=True) @ mixed
        normals.append(whole[1] - white[out].T @ white[out] - mixed.T @ moves + prior)
        missed = (plain[fold == k] - turned[fold == k] @ moves).reshape(-1, plain.shape[-1])
        gaps.append(missed.T @ missed)
    gap, normal = np.stack(gaps), np.stack(normals)
    return _Folds((gap[:, :-1, :-1], gap[:, :-1, -1], gap[:, -1, -1]), (normal[:, :-1, :-1], normal[:, :-1, -1]))


def _solve(square: Array, right: Array, inside: Bools) -> Array:
    """Solve for those unknowns that are inside, the others being 0: (a, a), (a,), (c, a) -> (c, a)."""
    size = 1.0 / np.sqrt(np.diag(square))
    both = inside[:, :, None] & inside[:, None, :]
    scaled = np.where(both, size[:, None] * square * size, np.eye(len(size)))
    return size * np.linalg.solve(scaled, np.where(inside, size * right, 0.0)[..., None])[..., 0]
