"""The least-squares solver: bounded Levenberg-Marquardt with geodesic acceleration, many candidates at once.

Every fit of the package uses it: the descents of a multistart, the fit of a calibration, the fits without some
poses, the refits of a diagnosis. Levenberg 1944, Marquardt 1963; damping by Nielsen 1999; acceleration by Transtrum
and Sethna 2012, Improvements to the Levenberg-Marquardt algorithm, for the long curved valleys of few poses.
After a failed step, the damping shortens the next one as in Moré's trust region (1978): to the minimum of the parabola
through both costs and the slope.

A candidate has converged when the best undamped step within the bounds would lower its cost by no more than a
share `tol` of it, or by no more than rounding: the remaining decrease counts, not the length of the last step.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.estimation.bounded_step import EPS, bounded_steps
from robolaser.estimation.problem import Problem
from robolaser.estimation.robust_loss import of_numbers

TOLERANCE = 1e-13
SHARE, ENOUGH = 1e-5, 1e-2
"""Of fits of whitened rows: share of their chi-squared, or chi-squared, that they may be above the optimum. Noise alone
moves it by more than 1."""
MOST_STEPS = 3000  # few points leave long curved valleys: 200 steps were needed along one, 20 are usual
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-8, 1e-14, 1e12
"""In units of the squared length of each column; the least one keeps steps out of directions that move no row."""
MOST_RELIEF = 0.1  # factor by which the damping falls after a step that lowered the cost as predicted
SHORTER = 0.1, 0.5  # least and largest share of a failed step, for the next one
PROBE = 0.1  # share of a step at which the residuals' second derivative along it is measured
ACCELERATED = 0.75  # length of the acceleration, relative to the step, up to which it is applied
OF_LOSS = 1e-2
"""Share of a solution's excess cost over its rival by which it may miss its optimum: a bad one need not be exact."""
AS_PREDICTED, FALL = 0.1, 0.1
"""Share of the predicted gain by which a step's gain may differ for the next one to reuse its derivatives; and the
largest ratio of such a step's predicted gain to the one before."""
TINY = float(np.finfo(np.float64).tiny)
KEPT = 4_000_000
"""Most numbers of derivatives that are kept, 32 MB. With more rows, steps need no acceleration and have none."""


@final
@dataclass(frozen=True, eq=False)
class Solution:
    """The solver's result for each of c candidates."""

    x: Array  # the parameters, (c, d)
    cost: Array  # their cost, (c,); infinite where it is not finite at the start, which is then x
    converged: Bools  # whether the best undamped step would lower it by no more than the tolerance, or rounding, (c,)
    evaluations: int  # residual vectors evaluated in all; a Jacobian counts as one for each parameter
    slopes: Array | None = None  # derivatives of the residuals by each parameter over its scale, (c, d, K), if known


def solve(
    problem: Problem,
    starts: Array,
    *,
    kept: Bools | None = None,
    tol: float = TOLERANCE,
    enough: float = 0.0,
    most_steps: int = MOST_STEPS,
    hopeless: Callable[[Array, Bools, Ints], Bools] | None = None,
    slopes: Array | None = None,
    rival: float = np.inf,
    close: bool = False,
) -> Solution:
    """Descend from each start to the optimum of its valley.

    Residuals that are not finite are infinitely bad: steps shrink until they avoid them.

    Args:
        problem: What to minimise.
        starts: (c, d); moved to the nearest point within the bounds.
        kept: Rows that count, for each candidate, (c, m); all when absent.
        tol: Share of the cost, see above.
        enough: Cost by which an optimum may be missed: some chi-squared where rows are whitened.
        most_steps: After which a candidate is given up.
        hopeless: Selects after each step the candidates to give up, from the cost, the convergence and the steps of
            all that are solved together, (c,) each.
        slopes: Derivatives of the residuals by each parameter over its scale near the starts, (d, K), where they are
            known: the first steps are chord steps with them. With some rows only: at the starts.
        rival: Cost of another solution, the better one where these cost much more.
        close: Whether candidates stay so close together that derivatives between them serve all.
    """
    starts = np.clip(np.asarray(starts, np.float64), problem.lower, problem.upper)
    if len(starts) == 0:
        none = np.empty(0)
        return Solution(starts, none, none > 0, 0)
    numbers = max(1, problem.rows) * (len(problem.scale) + 1) * 3
    at_once = max(1, KEPT // numbers)
    parts = [slice(i, i + at_once) for i in range(0, len(starts), at_once)]
    ends = [
        _Descents(
            problem, starts[part], None if kept is None else kept[part], tol, enough, rival, most_steps, close=close
        ).run(hopeless, slopes)
        for part in parts
    ]
    if len(ends) == 1:
        return ends[0]
    x, cost, converged = (np.concatenate([getattr(end, name) for end in ends]) for name in ("x", "cost", "converged"))
    return Solution(x, cost, converged, sum(end.evaluations for end in ends))


@dataclass(eq=False)
class _Descents:
    """The state of all candidates during a descent.

    Steps are measured in units of each parameter's scale, and damped in units of the largest derivatives so far. Where
    an optimum may be missed by some cost, steps that gain what is predicted are followed by chord steps, with the same
    derivatives, while their predicted gains fall; `_bent` is the cost that the change of the derivatives may hide.
    """

    problem: Problem
    x: Array
    kept: Bools | None
    tol: float
    enough: float
    rival: float
    most_steps: int
    close: bool

    def __post_init__(self) -> None:
        x, (c, d) = self.x, self.x.shape
        self.x = x.copy()
        self._A, self._g, self._lengths = np.zeros((c, d, d)), np.zeros((c, d)), np.zeros((c, d))
        self._damping, self._growth = np.full(c, FIRST_DAMPING), np.full(c, 2.0)
        self._side = np.zeros((c, d), dtype=np.int64)
        self._converged, self._iterations = np.zeros(c, dtype=bool), np.zeros(c, dtype=np.int64)
        self._promised, self._bent, self._chord = np.full(c, np.inf), np.zeros(c), np.zeros(c, dtype=bool)
        self._evaluations, self._curved = c, False
        self._r = [self._of_batch(i, x, np.arange(c)) for i in range(len(self.problem.batches))]
        keeps = sum(r.size for r in self._r) * d <= KEPT
        self._J = [np.zeros((c, d, r.shape[1])) for r in self._r] if keeps else []
        self._cost = self._costs(x, self._r)

    def run(self, hopeless: Callable[[Array, Bools, Ints], Bools] | None, slopes: Array | None) -> Solution:
        """Continue until all candidates have converged or were given up."""
        active = np.flatnonzero(np.isfinite(self._cost))
        near = slopes is not None and len(self._J) == 1
        if near:
            self._J[0][:] = slopes
        if near and self.kept is None:  # an end that matters is looked at with derivatives of its own
            self._bent[:] = self.enough
        elif near and self.kept is not None:
            self._J[0] *= self.kept[:, None, self.problem.row_of_number]
        if len(active):
            self._linearize(active, chord=near)
            self._chord &= self.kept is None
        for _ in range(4 * MOST_STEPS):
            if not len(active):
                break
            active = self._advance(active)
            active = active[self._iterations[active] < self.most_steps]
            if hopeless and len(active):
                active = active[~hopeless(self._cost, self._converged, self._iterations)[active]]
        slopes = self._J[0] if len(self._J) == 1 and self.kept is None and not self._chord.any() else None
        return Solution(self.x, self._cost, self._converged, self._evaluations, slopes)

    def _of_batch(self, batch: int, x: Array, which: Ints) -> Array:
        """Residuals of a batch that count, (c, d) -> (c, K)."""
        rows, part = self.problem.batches[batch]
        together = bool((x == x[0]).all())
        r = part.residuals(x[:1]).repeat(len(x), axis=0) if together else part.residuals(x)
        return r if self.kept is None else np.asarray(r * self.kept[which][:, rows][:, part.row_of_number])

    def _costs(self, x: Array, residuals: list[Array]) -> Array:
        """Cost of candidates (c, d) with their residuals, (c,)."""
        costs: Array = np.square(self.problem.extra_residuals(x)).sum(axis=1)
        for (_, part), r in zip(self.problem.batches, residuals, strict=True):
            costs = costs + part.loss.costs(r, part.starts)
        return costs

    def _linearize(self, which: Ints, *, chord: bool = False) -> None:
        """Compute the quadratic model of candidates; on a chord with their present derivatives."""
        x = self.x[which]
        together = bool((x == x[0]).all())
        places = x[:1] if together else x.mean(axis=0, keepdims=True) if self.close else x
        same = chord and self._curved and all(part.loss.is_square for _, part in self.problem.batches)
        J = self.problem.extra_jacobian(self.x[which])
        A = self._A[which] if same else J @ np.swapaxes(J, 1, 2)
        g = (J @ self.problem.extra_residuals(self.x[which])[..., None])[..., 0]
        for i, (rows, part) in enumerate(self.problem.batches):
            J = self._J[i][which] if chord else part.jacobian(places)
            if self.kept is not None and not chord:
                J = J * self.kept[which][:, rows][:, None, part.row_of_number]
            if self._J and not chord:
                self._J[i][which] = J
            r, J = part.loss.linearized(self._r[i][which], J, part.starts)
            if not same:
                A += J @ np.swapaxes(J, 1, 2)
            g += (J @ r[..., None])[..., 0]
        self._A[which], self._g[which] = A, g
        self._lengths[which] = np.maximum(self._lengths[which], np.sqrt(np.einsum("cii->ci", A)))
        self._chord[which], self._curved = chord, True
        self._evaluations += 0 if chord else len(places) * A.shape[1]

    def _advance(self, active: Ints) -> Ints:
        """Try a step of each candidate; returns the active ones."""
        problem, c = self.problem, len(active)
        x, cost, damping = self.x[active], self._cost[active], self._damping[active]
        unit = np.where(self._lengths[active] > 0.0, self._lengths[active], 1.0)
        A = self._A[active] / unit[:, :, None] / unit[:, None, :]
        g = self._g[active] / unit
        room = (problem.lower - x) / problem.scale * unit, (problem.upper - x) / problem.scale * unit

        step, predicted, side = _damped(A, damping, g, *room, self._side[active])
        self._side[active] = side
        digits = EPS * np.abs(x / problem.scale)
        least = np.maximum(self.tol * cost, np.square((digits * self._lengths[active]).sum(axis=1)))
        worth = np.maximum(self.enough, OF_LOSS * (cost - self.rival))
        enough = np.maximum(least, worth)
        to_go = predicted.copy()  # the undamped step may be predicted to gain less, which matters near the optimum only
        near = np.flatnonzero(predicted <= enough)
        if len(near):
            undamped = np.full(len(near), LEAST_DAMPING)
            to_go[near] = _damped(A[near], undamped, g[near], room[0][near], room[1][near], side[near])[1]
        self._converged[active] = (to_go <= enough) | ((predicted <= least) & (to_go <= np.sqrt(self.tol) * cost))
        going = (to_go > enough) & (predicted > least) & (damping <= MOST_DAMPING)
        chord = self._chord[active]
        doubted = chord & np.where(going, predicted > FALL * self._promised[active], to_go + self._bent[active] > worth)
        again = active[doubted]
        if len(again):
            self._linearize(again)
            self._converged[again], going = False, going & ~doubted
        if not going.all():
            active, x, cost, damping, unit, A, g, step, side, predicted, chord, c = (
                *(part[going] for part in (active, x, cost, damping, unit, A, g, step, side, predicted, chord)),
                int(going.sum()),
            )
            room = room[0][going], room[1][going]
            if not c:
                return again

        if self._J and len(new := np.flatnonzero(~chord)):
            curvature = self._second_derivative(active[new], x[new], (step / unit)[new]) / unit[new]
            within = room[0][new], room[1][new], side[new]
            accelerated = _damped(A[new], damping[new], g[new] + 0.5 * curvature, *within)[0]
            lengths = np.linalg.norm(accelerated - step[new], axis=1), np.linalg.norm(step[new], axis=1)
            near = 2.0 * lengths[0] <= ACCELERATED * lengths[1]
            step[new[near]] = accelerated[near]
        trial = np.clip(x + problem.scale * (step / unit), problem.lower, problem.upper)
        trial = np.where(step >= room[1], problem.upper, np.where(step <= room[0], problem.lower, trial))
        residuals = [self._of_batch(i, trial, active) for i in range(len(problem.batches))]
        squares = np.maximum(np.square(step).sum(axis=1), TINY)
        self._take(active, trial, residuals, predicted, np.einsum("ci,cij,cj->c", step, A, step) / squares)
        return np.union1d(active, again)

    def _take(self, active: Ints, trial: Array, residuals: list[Array], predicted: Array, curvature: Array) -> None:
        """Accept steps (c, d) that lower the cost, and adapt the damping by the predicted gain, (c,).

        The curvature of the quadratic model along the step, (c,), is the damping that halves it.
        """
        c, cost, damping, chord = len(active), self._cost[active], self._damping[active], self._chord[active]
        there = self._costs(trial, residuals)
        self._evaluations += c
        better = there < cost
        gained = np.divide(cost - there, predicted, where=better, out=np.zeros(c))
        ratio = np.clip(gained, -1.0, 1.0)
        easier = np.maximum(damping * np.maximum(MOST_RELIEF, 1.0 - (2.0 * ratio - 1.0) ** 3), LEAST_DAMPING)
        harder = np.where(chord, 1.0, self._growth[active])
        rise = np.where(better, 0.0, np.where(np.isfinite(there), there, np.inf) - cost)
        share = np.clip(predicted / np.maximum(2.0 * predicted + rise, TINY), *SHORTER)
        shorter = np.where(chord, 0.0, curvature * (1.0 / share - 1.0))
        self._damping[active] = np.where(better, easier, np.maximum(damping * harder, shorter))
        self._growth[active] = np.where(better, 2.0, 2.0 * harder)
        straight = better & (np.abs(gained - 1.0) <= AS_PREDICTED) & bool(self._J and self.enough)
        bent = trial.shape[1] * np.square(gained - 1.0) * predicted
        self._bent[active], self._promised[active] = bent + np.where(chord, self._bent[active], 0.0), predicted
        moved = active[better]
        self.x[moved], self._cost[moved] = trial[better], there[better]
        self._iterations[active] += 1
        for mine, r in zip(self._r, residuals, strict=True):
            mine[moved] = r[better]
        going = self._iterations[active] < self.most_steps
        self._chord[active[better & ~going]] = True  # its derivatives are those of the step before
        for which, on_chord in ((straight & going, True), ((better | chord) & ~straight & going, False)):
            if which.any():
                self._linearize(active[which], chord=on_chord)

    def _second_derivative(self, active: Ints, x: Array, step: Array) -> Array:
        """Jᵀ r'' of the residuals' second derivative along each step, (c, d); zero where one is not finite."""
        problem = self.problem
        probe = np.clip(x + PROBE * problem.scale * step, problem.lower, problem.upper)
        curvature = np.zeros_like(step)
        for i, (_, part) in enumerate(problem.batches):
            r, J = self._r[i][active], self._J[i][active]
            second = self._of_batch(i, probe, active) - r - PROBE * (step[:, None] @ J)[:, 0]
            second *= 2.0 / PROBE**2
            if not part.loss.is_square:
                second *= of_numbers(part.loss.weights(r, part.starts), r, part.starts)
            with np.errstate(invalid="ignore"):
                curvature += (J @ second[..., None])[..., 0]
        self._evaluations += len(active)
        return np.where(np.isfinite(curvature).all(axis=1, keepdims=True), curvature, 0.0)


def _damped(A: Array, damping: Array, g: Array, lower: Array, upper: Array, side: Ints) -> tuple[Array, Array, Ints]:
    """The best damped steps (c, d), by how much each lowers the undamped model, (c,), and at which bounds they end."""
    steps, gains, side = bounded_steps(A + damping[:, None, None] * np.eye(A.shape[1]), g, lower, upper, side)
    return steps, gains + damping * np.square(steps).sum(axis=1), side
