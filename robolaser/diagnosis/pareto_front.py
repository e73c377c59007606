"""The gap against the number of effects: what each further effect buys, as the best sets of every size show."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2, binary_tournament
from pymoo.core.duplicate import DefaultDuplicateElimination
from pymoo.core.mating import Mating
from pymoo.operators.selection.tournament import TournamentSelection
from pymoo.optimize import minimize

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.result import rms
from robolaser.diagnosis.held_out_gap import held_out
from robolaser.diagnosis.penalized_fit import Fitted
from robolaser.diagnosis.result import ParetoPoint
from robolaser.diagnosis.score_tests import Signature, slopes, typical
from robolaser.diagnosis.verdict import price
from robolaser.operators import ArithmeticCrossover, NonUniformMutation
from robolaser.problems import Addition, BestAmplitudes, GapAgainstComplexity, Neighbourhood

LEADERS = 12
"""Effects that the front is made of."""
POPULATION = 60
GENERATIONS = 30
CROSSED = 0.85
MUTATED = 0.2
SLOWING = 1.0
"""Of the non-uniform mutation: inclusion numbers must go on crossing the middle."""
TRIED = 3
"""Matings to fill a generation: few effects have few sets, and soon none is new."""
LEAST = 1e-12
"""Share of a signature's square beyond which something of it is left beside those that were taken before."""


def front(fitted: Fitted, signatures: Sequence[Signature], fold_of_pose: Ints, seed: int) -> tuple[ParetoPoint, ...]:
    """The sets of effects that no set with as few has a smaller gap than, from none on.

    NSGA-II with the paper's operators chooses the sets; stepwise least squares gives it sets to start from. Gaps are
    those of the model as linear around the fit without effects, the shapes of the effects as their signatures have
    them, all amplitudes and ordinary parameters fitted without the fold that is predicted.

    Args:
        fitted: The calibrated model without effects.
        signatures: Of the effects that may be added.
        fold_of_pose: The group in which each pose is held out, (n,).
        seed: Of the search.

    Returns:
        Sets by their number of effects, each with a smaller gap than the one before.
    """
    path = stepwise(fitted, signatures)
    leaders = [signatures[i] for i in path]
    fold = fold_of_pose[fitted.problem.model.dataset.points.pose]
    if not leaders or len(np.unique(fold)) < 2:
        return (ParetoPoint((), rms(held_out(fitted, fold_of_pose))),)
    problem = question(fitted, leaders, fold)
    sets = np.unique(np.concatenate([_staircase(len(leaders)), searched(problem, seed)]), axis=0)
    gaps = problem.unseen(sets)
    return tuple(
        ParetoPoint(
            tuple(leader.candidate_effect for leader, inside in zip(leaders, sets[i], strict=True) if inside),
            float(gaps[i]),
        )
        for i in undominated(sets.sum(axis=1), gaps)
    )


def stepwise(fitted: Fitted, signatures: Sequence[Signature], most: int = LEADERS) -> list[int]:
    """The order in which effects are taken, each that which explains most for its price beside those before it.

    Args:
        fitted: The model that the signatures are held against.
        signatures: Of the effects.
        most: Effects to be taken.

    Returns:
        Indices of signatures.
    """
    if not signatures:
        return []
    columns = np.hstack([signature.columns for signature in signatures])
    size = np.maximum((np.hstack([signature.white for signature in signatures]) ** 2).sum(axis=0), np.finfo(float).tiny)
    tall = np.column_stack([columns / np.sqrt(size), fitted.rest])
    G = tall.T @ tall
    ends = np.cumsum([0] + [signature.columns.shape[1] for signature in signatures])
    spans = [np.arange(start, end) for start, end in pairwise(ends)]
    prices = [price(signature.candidate_effect, signature.tried) for signature in signatures]
    order: list[int] = []
    for _ in range(min(most, len(signatures))):
        left = [i for i in range(len(signatures)) if i not in order]
        worth = {i: G[spans[i], -1] @ _inverse(G, spans[i]) @ G[spans[i], -1] - prices[i] for i in left}
        best = max(left, key=worth.__getitem__)
        order.append(best)
        span = spans[best]
        G = G - G[:, span] @ _inverse(G, span) @ G[span]
    return order


def _inverse(G: Array, span: Ints) -> Array:
    values, vectors = np.linalg.eigh(G[np.ix_(span, span)])
    seen = values > LEAST
    found: Array = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T
    return found


def question(fitted: Fitted, signatures: Sequence[Signature], fold: Ints) -> GapAgainstComplexity:
    """The gap against complexity, near a fitted model.

    Args:
        fitted: The model without effects.
        signatures: Of the effects that may be added.
        fold: In which each row is held out, (m,).
    """
    m, d = fitted.plain.shape[0], len(fitted.x)
    located = _located(fitted, fold)

    def by(columns: Array) -> Array:
        return located(columns.reshape(m, 3, -1))

    model = Neighbourhood(
        white=fitted.rest,
        white_slopes=np.vstack([fitted.J, np.eye(d)]),
        plain=by(fitted.plain)[..., 0],
        plain_slopes=by(fitted.slopes * (fitted.problem.prior * ~fitted.stuck)),
        row=np.append(np.repeat(np.arange(m), 3), np.full(d, -1)),
    )
    additions = []
    for signature in signatures:
        candidate_effect = signature.candidate_effect
        plain = slopes(fitted, candidate_effect, np.array([signature.shapes]))
        additions.append(
            Addition(
                name=f"{candidate_effect.kind.name} {candidate_effect.where}",
                white=np.vstack([signature.white, np.zeros((d, len(plain)))]),
                plain=by(np.moveaxis(plain, 0, -1)),
                reach=np.array([bound for _, _, bound, _ in candidate_effect.kind.declared()])
                / typical(candidate_effect),
            )
        )
    return GapAgainstComplexity(model, additions, fold)


def searched(problem: GapAgainstComplexity, seed: int) -> Bools:
    """The sets of effects in NSGA-II's last generation, (c, n); the first effects are taken to be the best."""
    each_set_once = DefaultDuplicateElimination(func=lambda pop: problem.chosen(pop.get("X")).astype(float))
    mating = Mating(
        TournamentSelection(func_comp=binary_tournament),
        ArithmeticCrossover(prob=CROSSED),
        NonUniformMutation(prob_var=MUTATED, b=SLOWING),
        repair=BestAmplitudes(),
        eliminate_duplicates=each_set_once,
        n_max_iterations=TRIED,
    )
    first = _first_generation(problem, np.random.default_rng(seed))
    algorithm = NSGA2(POPULATION, first, mating=mating, eliminate_duplicates=each_set_once)
    found = minimize(problem, algorithm, ("n_gen", GENERATIONS), seed=seed)
    return problem.chosen(found.pop.get("X"))


def undominated(counts: Ints, gaps: Array) -> list[int]:
    """Indices of those than which none with as few effects has a smaller gap, by their number of effects."""
    front: list[int] = []
    for i in np.lexsort((gaps, counts)).tolist():
        if not front or gaps[i] < gaps[front[-1]]:
            front.append(i)
    return front


def _first_generation(problem: GapAgainstComplexity, rng: np.random.Generator) -> Array:
    """The staircase of the effects, best first, and random sets of every size.

    Inclusion numbers lie anywhere in their half, so that blends of two parents are new sets and not one or the other.
    """
    n = len(problem.names)
    size = rng.integers(0, n + 1, (POPULATION, 1))
    sets = np.concatenate([_staircase(n), rng.random((POPULATION, n)) < size / n])[:POPULATION]
    inclusion = (sets + rng.random(sets.shape)) / 2.0
    return problem.settled(np.hstack([inclusion, np.zeros((len(sets), len(problem.reach)))]))


def _staircase(n: int) -> Bools:
    """None, the first, the first two, and so on to all, (n + 1, n)."""
    return np.tri(n + 1, n, -1, dtype=bool)


def _located(fitted: Fitted, fold: Ints) -> Callable[[Array], Array]:
    """How columns of plain rows (m, 3, c) are seen: in a socket that is held out whole, from where its poses put it."""
    dataset = fitted.problem.model.dataset
    names = np.array(dataset.points.names)
    rows = [np.flatnonzero(names == name) for name in dict.fromkeys(dataset.points.names)]
    if dataset.kind != "socket" or any(len(np.unique(fold[own])) > 1 for own in rows):
        return lambda columns: columns

    def located(columns: Array) -> Array:
        centred = columns.copy()
        for own in rows:
            centred[own] -= centred[own].mean(axis=0)
        return centred

    return located
