"""Which is better, by how much, and how sure is that: a sentence or two."""

from collections.abc import Sequence

from robolaser.benchmark.standings import judge, words
from robolaser.benchmark.standings.table import Measure, Pair, Place


def answer(measure: Measure, places: Sequence[Place], *, problems: int, runs: int, comparisons: int) -> str:
    """Put an order into words.

    Args:
        measure: What runs are paid in.
        places: In order.
        problems: How many they are about.
        runs: Fewest of anybody ranked, on any problem.
        comparisons: That the p are corrected for.
    """
    ranked = [place for place in places if place.rank is not None]
    left_out = [place.algorithm for place in places if place.rank is None]
    if not ranked:
        said = ["Nobody can be ranked: there are too few runs."] if left_out else ["There are no runs yet."]
    elif len(ranked) == 1:
        said = [_alone(ranked[0], measure)]
    else:
        said = _several(measure, ranked, problems=problems, runs=runs, comparisons=comparisons)
    if ranked and left_out:
        said.append(f"Not ranked: {words.names(left_out)}.")
    return " ".join(said)


def _alone(place: Place, measure: Measure) -> str:
    price = ""
    if place.price.value is not None:
        price = f", at {words.figure(place.price.value)}{words.between(place.price)} {measure} each"
    return (
        f"Only {place.algorithm} is there to be ranked: it reached the target in {words.share(place.success)} of its "
        f"runs{price}."
    )


def _several(measure: Measure, ranked: list[Place], *, problems: int, runs: int, comparisons: int) -> list[str]:
    first = ranked[0].algorithm
    against = [(place.algorithm, place.against_first) for place in ranked[1:]]
    rivals = [name for name, pair in against if pair is None or not pair.told]
    beaten = [(name, pair) for name, pair in against if pair is not None and pair.told]
    said = []
    if not any(place.solved for place in ranked):
        said.append("Nobody reached the target: what counts is how close they came.")
    if not beaten:
        said += _nothing_told(measure, ranked, problems=problems, runs=runs, comparisons=comparisons)
        return [*said, *_surprise(ranked)]
    if not rivals:
        said.append(f"In {measure}, {first} is better than {_others(beaten)}{_reaching(ranked[0])}.")
    else:
        verb = "share" if len(rivals) > 1 else "shares"
        said.append(
            f"In {measure}, {first} {_stands_first(ranked)}{_reaching(ranked[0])}, but {words.names(rivals)} {verb} "
            f"the lead as far as {runs} seeds can tell; it is better than {words.names([name for name, _ in beaten])}."
        )
    said.append(_by_how_much(measure, ranked[0], *beaten[0], problems=problems, comparisons=comparisons))
    return [*said, *_surprise(ranked)]


def _surprise(ranked: list[Place]) -> list[str]:
    """Who reached the target, where that is not the first."""
    solved = [place.algorithm for place in ranked if place.solved]
    if not solved or ranked[0].solved:
        return []
    return [f"Only {words.names(solved)} reached the target, too seldom to stand first: most runs are ranked by how "
            "close they came."]  # fmt: skip


def _stands_first(ranked: list[Place]) -> str:
    level = [place.algorithm for place in ranked[1:] if place.rank == ranked[0].rank]
    return f"shares the first place with {words.names(level)}" if level else "stands first"


def _others(beaten: list[tuple[str, Pair]]) -> str:
    if len(beaten) == 1:
        return beaten[0][0]
    return "both others" if len(beaten) == 2 else f"all {len(beaten)} others"


def _reaching(place: Place) -> str:
    return f", reaching the target in {words.share(place.success)} of its runs" if place.solved else ""


def _by_how_much(measure: Measure, first: Place, next_: str, pair: Pair, *, problems: int, comparisons: int) -> str:
    sure = _how_sure(first.algorithm, next_, pair, comparisons)
    if not first.solved:
        return f"{next_} comes next: {sure}."
    if pair.ratio.value is None:
        return f"{next_} comes next, and never reached the target where {first.algorithm} did: {sure}."
    return f"{next_} comes next and {_price(measure, pair, problems)}; {sure}."


def _price(measure: Measure, pair: Pair, problems: int) -> str:
    solved = len(pair.ratio_problems)
    where = f" on the {solved} of {problems} problems where both reached it" if solved < problems else ""
    return f"{words.times_as(measure, pair.ratio)} to the target{where}"


def _how_sure(first: str, other: str, pair: Pair, comparisons: int) -> str:
    corrected = f" after correction for {comparisons} comparisons" if comparisons > 1 else ""
    return (
        f"a run of {first} does better than one of {other} in {words.share(pair.superiority)} of cases, "
        f"{words.chance(pair.p_adjusted or 0.0)}{corrected}"
    )


def _nothing_told(measure: Measure, ranked: list[Place], *, problems: int, runs: int, comparisons: int) -> list[str]:
    first, second = ranked[0], ranked[1]
    needed = judge.fewest_runs(problems, comparisons)
    if needed is not None and runs < needed:
        return [
            f"In {measure}, {first.algorithm} {_stands_first(ranked)}, but with {runs} "
            f"{'seed' if runs == 1 else 'seeds'} no difference can be told from chance, however large: it takes "
            f"{needed} at least."
        ]
    pair = second.against_first
    if pair is None or pair.p_adjusted is None:
        return [f"In {measure}, nothing can be told."]
    price = "comes next; " if pair.ratio.value is None else f"comes next and {_price(measure, pair, problems)}; "
    return [
        f"In {measure}, nobody can be told from {first.algorithm}, which {_stands_first(ranked)}: "
        f"{second.algorithm} {price}{_how_sure(first.algorithm, second.algorithm, pair, comparisons)}."
    ]
