"""The ranking in a sentence or two: which solver is better, by how much, and with which certainty."""

from collections.abc import Sequence

from robolaser.benchmark.standings.table import PairwiseComparison, Standing
from robolaser.benchmark.statistics.difference import fewest_runs
from robolaser.benchmark.statistics.intervals import IntervalEstimate

MANY = 3  # names that a sentence lists before it counts the others


def answer(standings: Sequence[Standing], *, problems: int, runs: int, comparisons: int) -> str:
    """A ranking in words, given the smallest number of runs of any ranked solver on any problem."""
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
    if (spent := standing.running_time).value is not None:
        time = f", with an expected running time of {figure(spent.value)}{between(spent)} evaluations"
    return (
        f"Only {standing.algorithm} can be ranked: it reached the target in {share(standing.success)} of its "
        f"runs{time}."
    )


def _several(ranked: list[Standing], *, problems: int, runs: int, comparisons: int) -> list[str]:
    first, second = ranked[0], ranked[1]
    beaten = [one.algorithm for one in ranked[1:] if one.against_first is not None and one.against_first.significant]
    rivals = [one.algorithm for one in ranked[1:] if one.algorithm not in beaten]
    lead, seeds = f"{first.algorithm} ranks first", f"{runs} {'seed' if runs == 1 else 'seeds'}"
    reaching = f", reaching the target in {share(first.success)} of its runs" if first.solved else ""
    needed = None if beaten else fewest_runs(problems, comparisons)
    sentences = []
    if not any(one.solved for one in ranked):
        sentences.append("No algorithm reached the target, so the ranking is by how close they came.")
    if not rivals:
        others = {1: beaten[0], 2: "both others"}.get(len(beaten), f"all {len(beaten)} others")
        sentences.append(f"{first.algorithm} is better than {others}{reaching}.")
    elif beaten:
        verb = "do" if len(rivals) > 1 else "does"
        sentences.append(
            f"{lead}{reaching}, but {names(rivals)} {verb} not differ significantly from it with {seeds}; it is better"
            f" than {names(beaten)}."
        )
    elif needed is not None and runs < needed:
        sentences.append(
            f"{lead}, but with {seeds} no difference can be significant, however large: at least {needed} are needed."
        )
    else:
        sentences.append(f"{lead}{reaching}, but no algorithm differs significantly from it with {seeds}.")
    if (pair := second.against_first) is not None and pair.p_adjusted is not None:
        sentences.append(_by_how_much(first, pair, problems=problems, comparisons=comparisons))
    return sentences


def _by_how_much(first: Standing, pair: PairwiseComparison, *, problems: int, comparisons: int) -> str:
    """The comparison of the second with the first."""
    how = f"{pair.other} comes next"
    if pair.ratio.value is not None:
        solved = len(pair.ratio_problems)
        where = f" on the {solved} of {problems} problems where both reached it" if solved < problems else ""
        times = f"{figure(pair.ratio.value)}{between(pair.ratio)} times"
        how += f" and needs {times} as many evaluations to the target{where}"
    elif first.solved:
        how += f", and never reached the target where {first.algorithm} did"
    corrected = f" after correction for {comparisons} comparisons" if comparisons > 1 else ""
    return (
        f"{how}: a run of {first.algorithm} does better than one of {pair.other} in"
        f" {share(pair.superiority)} of cases, {chance(pair.p_adjusted or 0.0)}{corrected}."
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
    value, lower, upper = (100 * (end or 0.0) for end in (estimate.value, estimate.lower, estimate.upper))
    return f"{value:.0f} % ({lower:.0f} to {upper:.0f} %)"


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
