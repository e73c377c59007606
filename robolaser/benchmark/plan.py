"""What is to be compared, and on what terms."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.benchmark.engines import Task
from robolaser.benchmark.problem import Question
from robolaser.benchmark.problem_specs import Source, sources
from robolaser.benchmark.result import Comparison, Contested, Effort
from robolaser.benchmark.single_run import Run
from robolaser.benchmark.solvers import DEFAULT, find
from robolaser.benchmark.solvers.solver import Contestant
from robolaser.benchmark.terms import BUDGET, MEMORY_LIMIT_B, SEEDS, TIME_LIMIT_S
from robolaser.errors import OperatorSetting
from robolaser.estimation.multistart import multistart

OUR_OWN = "robolaser's own search"
"""Who found a lowest cost that no contestant came below."""
THEORY = "theory"
OUR_SEEDS = (1, 2, 3)
"""Of our own search for the lowest cost, outside the contest."""
LOWER = 1e-9
"""A lowest cost counts as found by another only if it is lower by more than this share."""
PROBES, PROBE_SEED, PROBE_DIGITS = 8, 1, 9
"""Candidates by whose costs a question is recognised, and to how many digits: another machine may round otherwise."""


Key = tuple[str, str, int]
"""Problem, algorithm and seed of a run: what it is known by."""


def key(one: Run | Task) -> Key:
    """What a run is known by."""
    return one.problem, one.algorithm, one.seed


@final
@dataclass(frozen=True, eq=False)
class Contest:
    """Every contestant gets every question it has something to say on, once with each seed.

    Attributes:
        sources: Of the questions.
        contestants: Who takes part.
        seeds: The same for all: where contestants draw the same first candidates, they begin alike.
        budget: Evaluations a run may spend.
        time_limit_s: Wall time a run may take [s].
        memory_limit_b: Memory a run may take beyond what its process needs anyway [B].
    """

    sources: tuple[Source, ...]
    contestants: tuple[Contestant, ...]
    seeds: tuple[int, ...]
    budget: int
    time_limit_s: float
    memory_limit_b: int

    @classmethod
    def of(
        cls,
        problems: Sequence[str],
        algorithms: Sequence[str] = DEFAULT,
        *,
        seeds: int = SEEDS,
        first_seed: int = 1,
        budget: int = BUDGET,
        time_limit_s: float = TIME_LIMIT_S,
        memory_limit_b: int = MEMORY_LIMIT_B,
    ) -> "Contest":
        """What is asked for by texts.

        Args:
            problems: See `sources.source`.
            algorithms: See `contestants.find`; one that is named twice takes part once.
            seeds: How many.
            first_seed: From 1; the others follow it.
            budget: Evaluations a run may spend.
            time_limit_s: Wall time a run may take [s].
            memory_limit_b: Memory a run may take [B].

        Raises:
            WrongUsage: There is no such problem or algorithm, or it has no such setting.
            OperatorSetting: Nothing of something is asked for.
            RobolaserError: A data set is not right.
        """
        for what, value in (
            ("problems", len(problems)),
            ("algorithms", len(algorithms)),
            ("seeds", seeds),
            ("first_seed", first_seed),
            ("budget", budget),
            ("time_limit_s", time_limit_s),
            ("memory_limit_b", memory_limit_b),
        ):
            if not value > 0:
                raise OperatorSetting("Contest", what, value, "more than 0")
        return cls(
            sources(problems),
            tuple(find(name) for name in dict.fromkeys(algorithms)),
            tuple(range(first_seed, first_seed + seeds)),
            budget,
            time_limit_s,
            memory_limit_b,
        )

    @cached_property
    def questions(self) -> tuple[Question, ...]:
        """What is asked."""
        return tuple(source.question() for source in self.sources)

    @cached_property
    def refused(self) -> Mapping[tuple[str, str], str]:
        """Why a contestant has nothing to say on a question, by (question, contestant)."""
        return {
            (question.name, contestant.name): reason
            for question in self.questions
            for contestant in self.contestants
            if (reason := _refusal(contestant, question)) is not None
        }

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """All runs: all with the first seed first, so that a contest is fair whenever it is stopped."""
        return tuple(
            Task(source.name, contestant.name, seed, self.budget, self.time_limit_s, self.memory_limit_b)
            for seed in self.seeds
            for source in self.sources
            for contestant in self.contestants
            if (source.name, contestant.name) not in self.refused
        )

    @cached_property
    def fingerprints(self) -> Mapping[str, str]:
        """What a question is recognised by: its bounds, and what some candidates cost."""
        return {question.name: _fingerprint(question) for question in self.questions}

    def own(self, runs: Iterable[Run]) -> tuple[Run, ...]:
        """Those runs that are part of it."""
        asked = {key(task) for task in self.tasks}
        return tuple(run for run in runs if key(run) in asked)

    def so_far(self, runs: Iterable[Run], effort: Effort) -> Comparison:
        """What came of it, with the runs that were made."""
        runs = tuple(runs)
        return Comparison(
            problems=tuple(self._contested(question, runs) for question in self.questions),
            contestants={contestant.name: contestant.title for contestant in self.contestants},
            refused=self.refused,
            seeds=self.seeds,
            budget=self.budget,
            time_limit_s=self.time_limit_s,
            runs=runs,
            effort=effort,
        )

    @cached_property
    def _known(self) -> Mapping[str, tuple[float, str]]:
        return {question.name: _best_known(question) for question in self.questions}

    def _contested(self, question: Question, runs: tuple[Run, ...]) -> Contested:
        best, found_by = self._known[question.name]
        for run in runs:
            if run.problem == question.name and run.course.final < best - LOWER * abs(best):
                best, found_by = run.course.final, run.algorithm
        return Contested(
            question.name,
            question.title,
            question.family,
            question.dimension,
            question.unit,
            scale=max(abs(best), question.scale) if np.isfinite(best) else question.scale,
            best=best,
            found_by=found_by,
        )


def _refusal(contestant: Contestant, question: Question) -> str | None:
    try:
        return contestant.refuses(question)
    except Exception as error:  # somebody's own
        return f"it failed when it was asked whether it has anything to say ({type(error).__name__}: {error})"


def _best_known(question: Question) -> tuple[float, str]:
    """The lowest cost that is known without the contest, and whence."""
    if question.lowest is not None:
        return question.lowest, THEORY
    if question.model is None:
        return np.inf, ""
    return min(multistart(question.model, seed=seed).cost for seed in OUR_SEEDS), OUR_OWN


def _fingerprint(question: Question) -> str:
    probes = question.anywhere(np.random.default_rng(PROBE_SEED), PROBES)
    numbers = np.concatenate([question.lower, question.upper, question.cost(probes)])
    return " ".join(f"{number:.{PROBE_DIGITS}g}" for number in numbers)
