"""Standings and running times of solvers with their uncertainties, and a sentence on them.

Plain values throughout, ready for JSON: None is a missing number, never NaN or infinity.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from robolaser.benchmark.statistics.intervals import IntervalEstimate

FINAL = ("best", "lower_quartile", "median", "upper_quartile", "worst")
"""Quantiles of final costs, in units of the problem's scale; None is infinite."""


@final
@dataclass(frozen=True)
class ResultOnProblem:
    """One solver on one problem."""

    problem: str
    algorithm: str
    runs: int
    failed: int
    successes: int  # runs that reached the target for the ranking
    final: Mapping[str, float | None] | None  # `FINAL` of the lowest costs, over the best known; None without runs
    violation: float | None  # median of the lowest violations of runs that found no feasible candidate
    evaluations: IntervalEstimate  # expected running time (ERT) to the target, unsuccessful runs repeated
    run_seconds: float | None  # median wall time of a run [s]


@final
@dataclass(frozen=True)
class PairwiseComparison:
    """Comparison of two solvers."""

    one: str
    other: str
    superiority: IntervalEstimate  # A12: probability that a run of `one` is better; over several problems the mean
    ratio: IntervalEstimate  # ERT of `other` over that of `one`; geometric mean; None unless both reached it
    ratio_problems: tuple[str, ...]  # on which both reached the target
    p: float | None  # that equal solvers differ as much by chance
    p_adjusted: float | None  # by Holm for all comparisons
    significant: bool


@final
@dataclass(frozen=True)
class OperatorEffect:
    """Effect of an exchanged part, among otherwise equal runs: same problem, same other parts."""

    stock: str
    slot: str
    operator: str
    strata: int  # number of problems and pairs of algorithms
    superiority: IntervalEstimate  # mean A12 of runs with the part over runs without it; 0.5 is no effect
    ratio: IntervalEstimate  # ERT with the part over that without it; below 1 is faster
    p: float  # of van Elteren's test of the strata
    p_adjusted: float  # by Holm for all parts


@final
@dataclass(frozen=True)
class Standing:
    """The standing of a solver."""

    algorithm: str
    rank: int | None  # from 1, with ties; None where it cannot be ranked
    mean_rank: float | None  # over blocks (problem, seed)
    runs: int
    failed: int
    success: IntervalEstimate  # share of the runs that reached the target
    running_time: IntervalEstimate  # to it, in evaluations; None over several problems
    solved: int  # problems on which any run reached it
    against_first: PairwiseComparison | None  # the first as `one`; None for the first itself and the unranked
    unranked: str  # reason why it is not ranked; empty if it is


@final
@dataclass(frozen=True)
class Order:
    """Solvers in order, on one problem or a family."""

    problems: tuple[str, ...]
    places: tuple[Standing, ...]  # those that cannot be ranked last
    pairs: tuple[PairwiseComparison, ...]  # all of them, `one` ranked before `other`
    blocks: int  # pairs (problem, seed) in which each ranked solver has a run
    answer: str  # the ranking in a sentence or two


@final
@dataclass(frozen=True)
class OnProblem:
    """Standings on one problem."""

    problem: str
    order: Order
    results: tuple[ResultOnProblem, ...]  # in the order of the plan


@final
@dataclass(frozen=True)
class Standings:
    """Standings on a family of problems."""

    family: str
    tolerance: float  # of the target for the ranking
    seeds: int
    order: Order
    by_problem: tuple[OnProblem, ...]
    effects: tuple[OperatorEffect, ...]  # of exchanged parts
    scope: str  # validity of such results
