"""The share of a run that lies behind is read from how the run will end."""

import itertools
from types import SimpleNamespace

import pytest
from bowl import Bowl, running
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.termination import NoTermination, TerminateIfAll, TerminateIfAny, Termination
from pymoo.optimize import minimize
from pymoo.termination import get_termination
from pymoo.termination.collection import TerminationCollection
from pymoo.termination.default import DefaultSingleObjectiveTermination
from pymoo.termination.ftol import SingleObjectiveSpaceTermination
from pymoo.termination.robust import RobustTermination

from robolaser.operators.schedule import HORIZON, progress

TREES = {
    "plain": get_termination("n_gen", 50),
    "any": TerminateIfAny(get_termination("time", 60), get_termination("n_gen", 50)),
    "all": TerminateIfAll(get_termination("n_eval", 60), get_termination("n_gen", 50)),
    "collection": TerminationCollection(get_termination("fmin", 1.0), get_termination("n_gen", 50)),
    "default": DefaultSingleObjectiveTermination(n_max_gen=50),
    "deep": TerminateIfAny(NoTermination(), TerminateIfAll(RobustTermination(get_termination("n_gen", 50)))),
    "the smallest of several": TerminateIfAny(get_termination("n_gen", 70), get_termination("n_gen", 50)),
}


@pytest.mark.parametrize("termination", TREES.values(), ids=TREES.keys())
def test_a_last_generation_is_found_anywhere(termination):
    assert progress(running(1, termination)) == 0.0
    assert progress(running(11, termination)) == pytest.approx(10 / 50)
    assert progress(running(51, termination)) == 1.0
    assert progress(running(99, termination)) == 1.0


def shares(termination, **kwargs):
    seen = []

    class Watched(GA):
        def _infill(self):
            seen.append(progress(self))
            return super()._infill()

    minimize(Bowl(), Watched(pop_size=10, eliminate_duplicates=False), termination, seed=1, **kwargs)
    return seen


def test_the_end_that_comes_first_counts():
    first_by_evaluations = TerminateIfAny(get_termination("n_gen", 2000), get_termination("n_eval", 50))
    first_by_generations = TerminateIfAny(get_termination("n_gen", 5), get_termination("n_eval", 50_000))
    assert shares(first_by_evaluations) == pytest.approx([0.2, 0.4, 0.6, 0.8])
    assert shares(first_by_generations) == pytest.approx([0.2, 0.4, 0.6, 0.8])


def test_a_time_budget_is_a_clock(monkeypatch):
    ticks = itertools.count(100.0, 0.5)
    monkeypatch.setattr("time.time", lambda: next(ticks))
    assert shares(("time", 2)) == pytest.approx([0.25, 0.5, 0.75])


def test_without_an_end_the_papers_horizon_holds():
    assert progress(running(HORIZON // 4 + 1, NoTermination())) == 0.25
    assert progress(running(HORIZON // 4 + 1, get_termination("n_gen", float("inf")))) == 0.25


def test_how_little_changes_is_no_clock():
    idle = SingleObjectiveSpaceTermination()
    idle.perc = 0.99
    assert progress(running(101, RobustTermination(idle))) == 100 / HORIZON


def test_a_termination_of_unknown_kind_is_believed():
    class Mine(Termination):
        pass

    mine = Mine()
    mine.perc = 0.4
    assert progress(running(1, TerminateIfAny(mine))) == 0.4
    assert progress(SimpleNamespace(n_iter=1, termination=SimpleNamespace(perc=0.5))) == 0.5


def test_an_explicit_last_generation_overrides_all():
    assert progress(running(6, get_termination("n_gen", 50)), last_generation=10) == 0.5
