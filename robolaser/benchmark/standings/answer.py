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
    spent = standing.running_time
    time = "" if spent is None else f", with an expected running time of {figure(spent)} evaluations"
    return (
        f"Only {standing.algorithm} can be ranked: it reached the target in {share(standing.success)} of its "
        f"runs{time}."
    )


def _several(ranked: list[Standing], *, problems: int, runs: int, comparisons: int) -> list[str]:
    first, others = ranked[0], {one.algorithm: one.against_first for one in ranked[1:]}
    beaten = {name: pair for name, pair in others.items() if pair is not None and pair.significant}
    rivals = [name for name in others if name not in beaten]
    level = [one.algorithm for one in ranked[1:] if one.rank == first.rank]
    place = f"ties for first place with {names(level)}" if level else "ranks first"
    reaching = f", reaching the target in {share(first.success)} of its runs" if first.solved else ""
    sentences = []
    if not any(one.solved for one in ranked):
        sentences.append("No algorithm reached the target, so the ranking is by how close they came.")
    if not beaten:
        sentences.append(_nothing_significant(ranked, place, problems=problems, runs=runs, comparisons=comparisons))
    elif rivals:
        verb = "do" if len(rivals) > 1 else "does"
        sentences.append(
            f"{first.algorithm} {place}{reaching}, but {names(rivals)} {verb} not differ significantly from it with"
            f" {runs} seeds; it is better than {names(list(beaten))}."
        )
    else:
        all_ = {1: next(iter(beaten)), 2: "both others"}.get(len(beaten), f"all {len(beaten)} others")
        sentences.append(f"{first.algorithm} is better than {all_}{reaching}.")
    if beaten:
        sentences.append(_by_how_much(first, *next(iter(beaten.items())), problems=problems, comparisons=comparisons))
    solved = [one.algorithm for one in ranked if one.solved]
    if solved and not first.solved:
        sentences.append(
            f"Only {names(solved)} reached the target, but too rarely to rank first: most runs are ranked by how close"
            " they came."
        )
    return sentences


def _nothing_significant(ranked: list[Standing], place: str, *, problems: int, runs: int, comparisons: int) -> str:
    first, second, needed = ranked[0].algorithm, ranked[1].algorithm, fewest_runs(problems, comparisons)
    if needed is not None and runs < needed:
        return (
            f"{first} {place}, but with {runs} {'seed' if runs == 1 else 'seeds'} no difference can be significant,"
            f" however large: at least {needed} are needed."
        )
    pair = ranked[1].against_first
    if pair is None or pair.p_adjusted is None:
        return "The algorithms cannot be compared."
    comes = "comes next; " if pair.ratio is None else f"comes next and {_needs(pair, problems)}; "
    return (
        f"No algorithm differs significantly from {first}, which {place}: {second} {comes}"
        f"{_how_sure(first, second, pair, comparisons)}."
    )


def _by_how_much(first: Standing, next_: str, pair: PairwiseComparison, *, problems: int, comparisons: int) -> str:
    sure = _how_sure(first.algorithm, next_, pair, comparisons)
    if not first.solved:
        return f"{next_} comes next: {sure}."
    if pair.ratio is None:
        return f"{next_} comes next, and never reached the target where {first.algorithm} did: {sure}."
    return f"{next_} comes next and {_needs(pair, problems)}; {sure}."


def _needs(pair: PairwiseComparison, problems: int) -> str:
    solved = len(pair.ratio_problems)
    where = f" on the {solved} of {problems} problems where both reached it" if solved < problems else ""
    return f"needs {figure(pair.ratio or 0.0)} times as many evaluations to the target{where}"


def _how_sure(first: str, other: str, pair: PairwiseComparison, comparisons: int) -> str:
    corrected = f" after correction for {comparisons} comparisons" if comparisons > 1 else ""
    return (
        f"a run of {first} does better than one of {other} in {100 * (pair.superiority or 0.0):.0f} % of cases, "
        f"{chance(pair.p_adjusted or 0.0)}{corrected}"
    )


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
    lower, upper = estimate.lower or 0.0, estimate.upper or 0.0
    return f"{100 * estimate.value:.0f} % ({100 * lower:.0f} to {100 * upper:.0f} %)"


def names(of: Sequence[str]) -> str:
    """A list, as `a, b and c`, or `a, b, c and 4 others`."""
    if len(of) == 1:
        return of[0]
    shown, more = (of, 0) if len(of) <= MANY + 1 else (of[:MANY], len(of) - MANY)
    return f"{', '.join(shown)} and {more} others" if more else f"{', '.join(shown[:-1])} and {shown[-1]}"
