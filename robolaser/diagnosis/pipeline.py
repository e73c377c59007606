"""From a data set to its diagnosis."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.arrays import Ints
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.detection_limits import limits
from robolaser.diagnosis.discriminating_poses import next_poses
from robolaser.diagnosis.findings import findings_of, not_testable, places_of
from robolaser.diagnosis.held_out_gap import Unseen, folds
from robolaser.diagnosis.pareto_front import front
from robolaser.diagnosis.preparation import Beginning
from robolaser.diagnosis.pruning import believed, rest_of
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.score_tests import library
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.summary_text import sentence
from robolaser.diagnosis.verdict import FEWEST_POSES, dispersion, judge
from robolaser.diagnosis.warm_start import sought
from robolaser.errors import EffectUnknown
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import Effect

ROUNDS = 2
"""Times that gross errors are looked for again once effects are in the model."""

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
    candidate_effects = library(kinds, dataset) if enough else []
    observed, start = beginning.fitted(gross, candidate_effects)
    search = Search(start, candidate_effects, lambda what: tell(what, 0.3))
    final = sought(search)
    calmer = beginning.calmer(observed, start, final)
    if calmer is not None:
        start, earlier, found = calmer, final, search
        search = Search(start, candidate_effects, lambda what: tell(what, 0.4))
        final = sought(search, search.again(earlier, found))
    for _ in range(ROUNDS):
        again = beginning.gross(final)
        if np.array_equal(again, gross):
            break
        gross, earlier, found = again, final, search
        observed, start = beginning.fitted(gross, candidate_effects)
        search = Search(start, candidate_effects, lambda what: tell(what, 0.5))
        final = sought(search, search.again(earlier, found))
    fold = folds(observed, seed)
    unseen = Unseen(fold)

    tell("asking what else could be the cause", 0.6)
    final, standing, left = believed(search, final, unseen)
    lost = {stand.candidate_effect: stand.without.misfit - final.misfit for stand in standing}

    tell("holding poses out", 0.8)
    gap, findings, before, after = findings_of(search, start, final, standing, unseen, seed)
    verdict = judge(start, final, left, gap)
    places = rest_of(search, final, standing, left) if verdict == "unexplained" else places_of(start, final, lost)
    spread = dispersion(final)
    remaining = search.signatures(final)
    limit = limits(remaining, spread)
    front_ = front(start, search.signatures(start), fold, seed) if enough else ()
    unsure = [stand for stand in standing if stand.alternatives]
    following = next_poses(final, min(unsure, key=lambda s: s.probability).alternatives[0], seed=seed) if unsure else ()
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
        outliers=gross_rows,
        not_testable=not_testable(kinds, dataset, limit, enough=enough),
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
