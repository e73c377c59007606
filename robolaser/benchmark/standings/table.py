"""What is known of solvers: standings, running times, how sure both are, and sentences that say so.

Plain values throughout, ready for JSON: None stands for a number that there is none of, never NaN or infinity.
"""

from dataclasses import dataclass
from typing import Literal, final

Measure = Literal["evaluations", "seconds"]
"""What counts: evaluations or wall time."""


@final
@dataclass(frozen=True)
class IntervalEstimate:
    """A number and its 95 % interval.

    Attributes:
        value: None where the runs give none: an expected running time to a target that no run reached.
        lower: None where the runs leave it open.
        upper: None where the runs leave it open: it may be infinite, or there are too few runs to say.
    """

    value: float | None
    lower: float | None
    upper: float | None


@final
@dataclass(frozen=True)
class Reached:
    """How often a solver reached one target on one problem, and in what time.

    Attributes:
        tolerance: Of the target, over the lowest known cost, in units of the problem's scale.
        successes: Runs that reached it.
        success: Share of the runs that did, with Wilson's interval.
        evaluations: Expected running time (ERT): evaluations until the target is reached, unsuccessful runs repeated.
        seconds: The same in wall time [s].
    """

    tolerance: float
    successes: int
    success: IntervalEstimate
    evaluations: IntervalEstimate
    seconds: IntervalEstimate


@final
@dataclass(frozen=True)
class FinalCosts:
    """What runs ended with: lowest costs over the best known, in units of the problem's scale; None is infinite."""

    best: float | None
    lower_quartile: float | None
    median: float | None
    upper_quartile: float | None
    worst: float | None


@final
@dataclass(frozen=True)
class Result:
    """One solver on one problem.

    Attributes:
        problem: Its name.
        algorithm: Name of the solver.
        runs: Number of runs.
        failed: Number of runs that failed.
        final: What they ended with; None without runs.
        violation: Median of the lowest violations of runs that found no feasible candidate; None if all found one.
        targets: One for each target, tolerances falling.
    """

    problem: str
    algorithm: str
    runs: int
    failed: int
    final: FinalCosts | None
    violation: float | None
    targets: tuple[Reached, ...]


@final
@dataclass(frozen=True)
class Pair:
    """Two solvers against each other.

    Attributes:
        one: Name of a solver.
        other: Name of another.
        superiority: How often a run of the one does better than a run of the other, ties counting half: the A12 of
            Vargha and Delaney, over several problems its mean.
        effect: Its size in a word: negligible, small, medium or large; None without runs.
        ratio: Expected running time of the other over that of the one at the headline target; above one if the one is
            faster. Over several problems the geometric mean of those in `ratio_problems`.
        ratio_problems: Problems on which both reached the target.
        p: Probability of runs as different as these if the two were the same; None without runs.
        p_adjusted: After Holm's correction for all comparisons made.
        significant: Whether the two differ significantly.
    """

    one: str
    other: str
    superiority: IntervalEstimate
    effect: str | None
    ratio: IntervalEstimate
    ratio_problems: tuple[str, ...]
    p: float | None
    p_adjusted: float | None
    significant: bool


@final
@dataclass(frozen=True)
class Standing:
    """Where a solver stands.

    Attributes:
        algorithm: Its name.
        rank: From 1; equal mean ranks share one. None where it cannot be ranked with the others, see `unranked`.
        mean_rank: Over the blocks (problem, seed), 1 being the best; None as `rank`.
        runs: That were made.
        failed: Those of them that failed.
        success: Share of them that reached the headline target.
        running_time: Expected running time to the headline target, in the measure; None over several problems.
        solved: Problems on which any run reached it.
        area: Under the ECDF of running times on a logarithmic axis of budgets, 0 to 1; None without runs.
        against_first: The first as `one` and this solver as `other`; None for the first itself and the unranked.
        unranked: Why it is not ranked; empty if it is.
    """

    algorithm: str
    rank: int | None
    mean_rank: float | None
    runs: int
    failed: int
    success: IntervalEstimate
    running_time: IntervalEstimate
    solved: int
    area: float | None
    against_first: Pair | None
    unranked: str


@final
@dataclass(frozen=True)
class Ranks:
    """Mean ranks over complete blocks, and who does not differ significantly: all that a diagram of ranks shows.

    Attributes:
        algorithms: Names, the best mean rank first.
        mean_ranks: Of each.
        blocks: Pairs (problem, seed) in which each of them has a run.
        groups: Largest sets of two or more solvers no two of which differ significantly, by the tests of `pairs`.
    """

    algorithms: tuple[str, ...]
    mean_ranks: tuple[float, ...]
    blocks: int
    groups: tuple[tuple[str, ...], ...]


@final
@dataclass(frozen=True)
class Order:
    """Solvers in order, on some problems and in one measure.

    Attributes:
        measure: Evaluations or wall time.
        problems: Names of those it is about: one, or a family.
        places: The best first; those that cannot be ranked last.
        pairs: All of them, `one` standing before `other`.
        ranks: For the diagram of mean ranks.
        answer: Which is better, by how much, and how sure is that: a sentence or two.
    """

    measure: Measure
    problems: tuple[str, ...]
    places: tuple[Standing, ...]
    pairs: tuple[Pair, ...]
    ranks: Ranks
    answer: str


@final
@dataclass(frozen=True)
class OnProblem:
    """How solvers stand on one problem.

    Attributes:
        problem: Its name.
        evaluations: Their order when evaluations count.
        seconds: Their order when wall time counts.
        results: What each achieved, in the order of the plan.
    """

    problem: str
    evaluations: Order
    seconds: Order
    results: tuple[Result, ...]


@final
@dataclass(frozen=True)
class Standings:
    """How solvers stand on a family of problems.

    Attributes:
        family: Of the problems.
        tolerance: Of the headline target, by which they are ranked.
        seeds: Asked for.
        evaluations: Their order over all problems when evaluations count.
        seconds: Their order over all problems when wall time counts.
        by_problem: Each problem for itself.
        scope: What such results speak of, and what not.
    """

    family: str
    tolerance: float
    seeds: int
    evaluations: Order
    seconds: Order
    by_problem: tuple[OnProblem, ...]
    scope: str
