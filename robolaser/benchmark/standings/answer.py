"""The ranking in a sentence or two: which solver is better, by how much, and how certain that is."""

from collections.abc import Sequence

from robolaser.benchmark.standings.table import PairwiseComparison, Standing
from robolaser.benchmark.statistics.difference import fewest_runs
from robolaser.benchmark.statistics.intervals import IntervalEstimate

MANY = 3
"""Names that a sentence lists before it counts the others."""


def answer(standings: Sequence[Standing], *, problems: int, runs: int, comparisons: int) -> str:
    """Put an order into words, given the smallest number of runs of any ranked solver on any problem."""
    ranked = [standing for standing in standings if standing.rank is not None]
    left_out = [standing.algorithm for standing in standings if standing.rank is None]
    failed = [standing.algorithm for standing in standings if 0 < standing.runs == standing.failed]
    if failed and len(failed) == sum(standing.runs > 0 for standing in standings):
        return "Every run failed, so this comparison says nothing. The reasons are given with the runs."
    if not ranked:
        sentences = ["No algorithm can be ranked: there are too few runs."] if left_out else ["There are no runs yet."]
    elif len(ranked) == 1:
        sentences = [_alone(ranked[0])]
    else:
        sentences = _several(ranked, problems=problems, runs=runs, comparisons=comparisons)
    if ranked and left_out:
        sentences.append(f"Not ranked: {names(left_out)}.")
    if failed:
        sentences.append(f"Every run of {names(failed)} failed.")
    return " ".join(sentences)


def _alone(standing: Standing) -> str:
    time = ""
    if (expected := standing.running_time).value is not None:
        time = f", with an expected running time of {figure(expected.value)}{between(expected)} evaluations"
    return (
        f"Only {standing.algorithm} can be ranked: it reached the target in {share(standing.success)} of its "
        f"runs{time}."
    )


def _several(ranked: list[Standing], *, problems: int, runs: int, comparisons: int) -> list[str]:
    first = ranked[0].algorithm
    against = [(standing.algorithm, standing.against_first) for standing in ranked[1:]]
    rivals = [name for name, pair in against if pair is None or not pair.significant]
    beaten = [(name, pair) for name, pair in against if pair is not None and pair.significant]
    sentences = []
    if not any(standing.solved for standing in ranked):
        sentences.append("No algorithm reached the target, so the ranking is by how close they came.")
    if not beaten:
        sentences += _nothing_significant(ranked, problems=problems, runs=runs, comparisons=comparisons)
        return [*sentences, *_surprise(ranked)]
    if not rivals:
        sentences.append(f"{first} is better than {_others(beaten)}{_reaching(ranked[0])}.")
    else:
        verb = "do" if len(rivals) > 1 else "does"
        sentences.append(
            f"{first} {_ranks_first(ranked)}{_reaching(ranked[0])}, but {names(rivals)} {verb} "
            f"not differ significantly from it with {runs} seeds; it is better than "
            f"{names([name for name, _ in beaten])}."
        )
    sentences.append(_by_how_much(ranked[0], *beaten[0], problems=problems, comparisons=comparisons))
    return [*sentences, *_surprise(ranked)]


def _surprise(ranked: list[Standing]) -> list[str]:
    """Name the solvers that reached the target, if the first did not."""
    solved = [standing.algorithm for standing in ranked if standing.solved]
    if not solved or ranked[0].solved:
        return []
    return [f"Only {names(solved)} reached the target, but too rarely to rank first: most runs are ranked by "
            "how close they came."]  # fmt: skip


def _ranks_first(ranked: list[Standing]) -> str:
    level = [standing.algorithm for standing in ranked[1:] if standing.rank == ranked[0].rank]
    return f"ties for first place with {names(level)}" if level else "ranks first"


def _others(beaten: list[tuple[str, PairwiseComparison]]) -> str:
    if len(beaten) == 1:
        return beaten[0][0]
    return "both others" if len(beaten) == 2 else f"all {len(beaten)} others"


def _reaching(standing: Standing) -> str:
    return f", reaching the target in {share(standing.success)} of its runs" if standing.solved else ""


def _by_how_much(first: Standing, next_: str, pair: PairwiseComparison, *, problems: int, comparisons: int) -> str:
    sure = _how_sure(first.algorithm, next_, pair, comparisons)
    if not first.solved:
        return f"{next_} comes next: {sure}."
    if pair.ratio.value is None:
        return f"{next_} comes next, and never reached the target where {first.algorithm} did: {sure}."
    return f"{next_} comes next and {_needs(pair, problems)}; {sure}."


def _needs(pair: PairwiseComparison, problems: int) -> str:
    solved = len(pair.ratio_problems)
    where = f" on the {solved} of {problems} problems where both reached it" if solved < problems else ""
    return f"{times_as(pair.ratio)} to the target{where}"


def _how_sure(first: str, other: str, pair: PairwiseComparison, comparisons: int) -> str:
    corrected = f" after correction for {comparisons} comparisons" if comparisons > 1 else ""
    return (
        f"a run of {first} does better than one of {other} in {share(pair.superiority)} of cases, "
        f"{chance(pair.p_adjusted or 0.0)}{corrected}"
    )


def _nothing_significant(ranked: list[Standing], *, problems: int, runs: int, comparisons: int) -> list[str]:
    first, second = ranked[0], ranked[1]
    needed = fewest_runs(problems, comparisons)
    if needed is not None and runs < needed:
        return [
            f"{first.algorithm} {_ranks_first(ranked)}, but with {runs} "
            f"{'seed' if runs == 1 else 'seeds'} no difference can be significant, however large: at least "
            f"{needed} are needed."
        ]
    pair = second.against_first
    if pair is None or pair.p_adjusted is None:
        return ["The algorithms cannot be compared."]
    comes = "comes next; " if pair.ratio.value is None else f"comes next and {_needs(pair, problems)}; "
    return [
        f"No algorithm differs significantly from {first.algorithm}, which {_ranks_first(ranked)}: "
        f"{second.algorithm} {comes}{_how_sure(first.algorithm, second.algorithm, pair, comparisons)}."
    ]


def figure(number: float) -> str:
    """Two digits: 1,200, 3.1, 0.045."""
    rounded = float(f"{number:.2g}")
    return f"{rounded:,.0f}" if rounded >= 10 else f"{rounded:g}"


def chance(p: float) -> str:
    """A probability, as `p = 0.013`."""
    return "p < 0.001" if p < 1e-3 else f"p = {p:.2g}"


def share(estimate: IntervalEstimate) -> str:
    """A share with its interval, as `80 % (49 to 94 %)`."""
    if estimate.value is None:
        return "an unknown share"
    if estimate.lower is None or estimate.upper is None:
        return f"{estimate.value:.0%}".replace("%", " %")
    return f"{100 * estimate.value:.0f} % ({100 * estimate.lower:.0f} to {100 * estimate.upper:.0f} %)"


def between(estimate: IntervalEstimate) -> str:
    """An interval in brackets, as ` (1.8 to 3.1)`; open ends are stated."""
    if estimate.lower is None:
        return " (too few seeds for an interval)"
    if estimate.upper is None:
        return f" (at least {figure(estimate.lower)})"
    return f" ({figure(estimate.lower)} to {figure(estimate.upper)})"


def names(of: Sequence[str]) -> str:
    """A list, as `a, b and c`, or `a, b, c and 4 others`."""
    if len(of) == 1:
        return of[0]
    shown, more = (of, 0) if len(of) <= MANY + 1 else (of[:MANY], len(of) - MANY)
    return f"{', '.join(shown)} and {more} others" if more else f"{', '.join(shown[:-1])} and {shown[-1]}"


def times_as(ratio: IntervalEstimate) -> str:
    """A ratio of running times, as `needs 2.3 (1.8 to 3.1) times as many evaluations`."""
    return f"needs {figure(ratio.value or 0.0)}{between(ratio)} times as many evaluations"
