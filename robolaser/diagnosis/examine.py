"""From a data set to its diagnosis."""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import chi2
from threadpoolctl import threadpool_limits

from robolaser.arrays import Array, Ints
from robolaser.dataset import Dataset
from robolaser.diagnosis.beginning import Beginning
from robolaser.diagnosis.fitted import Fitted
from robolaser.diagnosis.front import front
from robolaser.diagnosis.gap import folds, held_out, interval, rms
from robolaser.diagnosis.limits import limits
from robolaser.diagnosis.next_poses import next_poses
from robolaser.diagnosis.observed import of_rows, size
from robolaser.diagnosis.result import Diagnosis, Finding, Gap, Limit, Number, Rival
from robolaser.diagnosis.rivals import Stand, echoes, rival, stand
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.signatures import library
from robolaser.diagnosis.sought import sought
from robolaser.diagnosis.verdict import BELIEVED, FEWEST_POSES, dispersion, judge
from robolaser.diagnosis.where import Lies, where
from robolaser.diagnosis.words import sentence
from robolaser.effects import EFFECTS
from robolaser.effects.effect import Effect, Suspect
from robolaser.errors import EffectUnknown

ROUNDS = 2
"""Times that gross errors are looked for again once effects are in the model."""

MOST_RIVALS = 6
"""Rivals that are told of each effect, the nearest first."""

Progress = Callable[[str, float], None]


def diagnose(
    dataset: Dataset, effects: Sequence[type[Effect]] | None = None, seed: int | None = None
) -> dict[str, Any]:
    """Say where the gap lies, which effects cause it, and how far it shrinks.

    Args:
        dataset: The real; its nominal parameters are the sim.
        effects: The library of effects; `[*robolaser.EFFECTS, Mine]` extends ours.
        seed: Deals poses into folds and resamples them; the same one, the same answer.

    Returns:
        What diagnosis.json holds: gaps in millimetres, else SI.

    Raises:
        NoPoints, NothingSeen: The data set holds nothing to judge.
    """
    return examine(dataset, effects, seed=seed).as_json()


def examine(
    dataset: Dataset,
    effects: Sequence[type[Effect]] | None = None,
    *,
    seed: int | None = None,
    without: Sequence[str] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """The same, with all that a report shows.

    Args:
        dataset: The real; its nominal parameters are the sim.
        effects: The library of effects.
        seed: Of everything random.
        without: Names of effects that are taken out of the library.
        progress: Is told what is going on, and what share of the work is done.

    Raises:
        EffectUnknown: There is no such effect to take out.
        NoPoints, NothingSeen: The data set holds nothing to judge.
    """
    began = time.perf_counter()
    with threadpool_limits(limits=1, user_api="blas"):
        return _examine(dataset, _kinds(effects, without), seed or 0, progress or (lambda what, share: None), began)


def _kinds(effects: Sequence[type[Effect]] | None, without: Sequence[str]) -> list[type[Effect]]:
    kinds = list(EFFECTS if effects is None else effects)
    for name in without:
        if name not in {kind.name for kind in kinds}:
            raise EffectUnknown(name, {kind.name: kind for kind in kinds})
    return [kind for kind in kinds if kind.name not in without]


def _examine(dataset: Dataset, kinds: list[type[Effect]], seed: int, tell: Progress, began: float) -> Diagnosis:
    tell("fitting the nominal model", 0.0)
    beginning, gross = Beginning.of(dataset)
    enough = len(np.unique(dataset.points.pose)) >= FEWEST_POSES
    suspects = library(kinds, dataset) if enough else []
    observed, start = beginning.fitted(gross, suspects)
    search = Search(start, suspects, lambda what: tell(what, 0.3))
    final = sought(search)
    for _ in range(ROUNDS):
        again = beginning.gross(final)
        if np.array_equal(again, gross):
            break
        gross, earlier, found = again, final, search
        observed, start = beginning.fitted(gross, suspects)
        search = Search(start, suspects, lambda what: tell(what, 0.5))
        final = sought(search, search.again(earlier, found))
    fold = folds(observed, seed)

    tell("asking what else could be the cause", 0.6)
    final, standing, left = _believed(search, final)
    lost = {stand.suspect: stand.without.misfit - final.misfit for stand in standing}

    tell("holding poses out", 0.8)
    gap, findings, before, after = _findings(dataset, search, start, final, standing, fold, seed)
    verdict = judge(start, final, left, gap)
    places = _rest(search, final, standing, left) if verdict == "unexplained" else _places(start, final, lost)
    spread = dispersion(final)
    remaining = search.signatures(final)
    limit = limits(remaining, spread)
    front_ = front(start, search.signatures(start), fold, seed) if enough else ()
    unsure = [stand for stand in standing if stand.rivals]
    following = next_poses(final, min(unsure, key=lambda s: s.probability).rivals[0], seed=seed) if unsure else ()
    gross_rows: Ints = np.flatnonzero(gross).astype(np.int64)
    problem = final.problem
    deviations = np.sqrt(np.maximum(np.diag(final.covariance), 0.0))
    return Diagnosis(
        dataset=dataset,
        verdict=verdict,
        sentence=sentence(verdict, findings, places, gap, gross_rows),
        gap=gap,
        where=tuple(places) if verdict != "no_gap" else (),
        findings=findings,
        gross=gross_rows,
        not_testable=_not_testable(kinds, dataset, limit, enough=enough),
        next_poses=tuple(following),
        limits=limit,
        front=tuple(front_),
        model=problem.model,
        x=final.x,
        std=np.where(problem.prior > 0, deviations, np.nan),
        observed=observed.dataset,
        before_m=before,
        after_m=after,
        noise=dict(problem.noise.sigmas),
        seconds=time.perf_counter() - began,
        names=problem.parameters.names,
    )


def _believed(search: Search, final: Fitted) -> tuple[Fitted, list[Stand], list[Lies]]:
    """Take back effects that something unknown explains better, and those that only echo the form of a larger one."""
    left = where(final)
    while True:
        spread = dispersion(final)
        strange = {
            suspect: search.strange(final, search.fit(final, removed=suspect)) if left else 0.0
            for suspect in final.suspects
        }
        doubtful = sorted((suspect for suspect in strange if strange[suspect] > BELIEVED), key=lambda s: -strange[s])
        if not doubtful:
            rest = sum(lies.likelihood_ratio for lies in left)
            standing = [stand(search, final, suspect, spread, strange[suspect], rest) for suspect in final.suspects]
            doubtful = echoes(standing, final)
        if not doubtful:
            return final, standing, left
        for suspect in doubtful[: max(1, len(doubtful) // 2)]:
            final = search.fit(final, removed=suspect)
        left = where(final)


def _rest(search: Search, final: Fitted, standing: Sequence[Stand], left: list[Lies]) -> list[Lies]:
    """Where lies what is left by those effects that are rather believed than not."""
    doubted = [one.suspect for one in standing if one.probability < BELIEVED]
    for suspect in doubted:
        final = search.fit(final, removed=suspect)
    return where(final) if doubted else left


def _findings(
    dataset: Dataset, search: Search, start: Fitted, final: Fitted, standing: list[Stand], fold: Ints, seed: int
) -> tuple[Gap, tuple[Finding, ...], Array, Array]:
    """The held-out gap step by step, the effects added in the order in which they help most."""
    before = held_out(start, fold)
    after = held_out(final, fold) if final.suspects else before
    order, state = [], start
    by_suspect = {signature.suspect: signature for signature in search.seen(final)}
    gaps = [rms(before)]
    remaining = list(final.suspects)
    while remaining:
        options = [search.fit(state, [by_suspect[suspect]]) for suspect in remaining]
        best = int(np.argmin([option.misfit for option in options]))
        order.append(remaining.pop(best))
        state = options[best]
        gaps.append(rms(held_out(state, fold)) if remaining else rms(after))
    stand_of = {stand.suspect: stand for stand in standing}
    findings = tuple(
        Finding(
            suspect=suspect,
            probability=stand_of[suspect].probability,
            numbers=_numbers(final, suspect),
            gap_before_m=gaps[i],
            gap_after_m=gaps[i + 1],
            gap_without_m=rms(held_out(stand_of[suspect].without, fold)),
            rivals=_rivals(stand_of[suspect], final, fold),
        )
        for i, suspect in enumerate(order)
    )
    given = any(item.given for item in start.problem.sensor.items)
    nominal = start.problem.plain(start.problem.parameters.nominal[None])[0] if given else start.plain
    floor = size(of_rows(final.problem.noise))
    gap = Gap(rms(nominal), gaps[0], rms(after), floor, interval(after, start.problem.model.dataset.points.pose, seed))
    return gap, findings, before, after


def _rivals(stand: Stand, final: Fitted, fold: Ints) -> tuple[Rival, ...]:
    return tuple(
        Rival(suspect, _numbers(fit, suspect), rms(held_out(fit, fold)))
        for suspect, fit in zip(rival(stand, final)[:MOST_RIVALS], stand.rivals, strict=False)
    )


def _numbers(final: Fitted, suspect: Suspect) -> Mapping[str, Number]:
    names = final.problem.parameters.names
    found = {}
    for item in suspect.parameters.items:
        column = names.index(item.name)
        variance = float(final.covariance[column, column])
        found[item.name.rsplit(".", 1)[1]] = Number(
            float(final.x[column]), float(np.sqrt(max(variance, 0.0))), item.unit
        )
    return found


def _places(start: Fitted, final: Fitted, lost: Mapping[Suspect, float]) -> list[Lies]:
    """Where the gap lay, by what each effect explains of it."""
    freedoms = len(start.r) - len(start.x)
    excess = max(start.misfit - freedoms, 1e-9)
    closed = float(np.clip((start.misfit - final.misfit) / excess, 0.0, 1.0))
    total = max(sum(lost.values()), 1e-9)
    seen = {lies.site: lies for lies in reversed(where(start))}
    found: dict[str, Lies] = {}
    for suspect, gain in lost.items():
        share = closed * gain / total + (found[suspect.where].share if suspect.where in found else 0.0)
        coordinate = seen[suspect.where].coordinate if suspect.where in seen else suspect.kind.title
        p_value = float(chi2.sf(gain, len(suspect.kind.declared()) + len(suspect.kind.shapes())))
        found[suspect.where] = Lies(suspect.where, coordinate, share, gain, p_value)
    return sorted(found.values(), key=lambda lies: -lies.share)


def _not_testable(
    kinds: Sequence[type[Effect]], dataset: Dataset, limit: Sequence[Limit], *, enough: bool
) -> dict[str, str]:
    """Why an effect could not be tested, by its name."""
    if not enough:
        return {kind.name: f"fewer than {FEWEST_POSES} poses show something" for kind in kinds}
    reasons = {kind.name: reason for kind in kinds if (reason := kind.missing(dataset))}
    unseen: dict[str, list[str]] = {}
    for one in limit:
        if one.size is None:
            unseen.setdefault(one.suspect.kind.name, []).append(one.suspect.where)
    for name, places in unseen.items():
        reasons.setdefault(name, f"at {', '.join(places)} these poses cannot tell it from the ordinary parameters")
    return reasons
