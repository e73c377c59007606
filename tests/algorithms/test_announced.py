"""Algorithms and operators that other installed packages announce take part by name; a broken one is named."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from installed import installed

from robolaser.algorithms.registry import ALGORITHMS, algorithm_named, algorithms, operators
from robolaser.benchmark.solvers import DEFAULT, find, solver_titles
from robolaser.errors import PluginError, UsageError

CODE = '''
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.core.mutation import Mutation


class Greedy(DE):
    """Differential evolution around the best."""

    def __init__(self, pop_size=20, **kwargs):
        super().__init__(pop_size=pop_size, variant="DE/best/1/bin", **kwargs)


class Flip(Mutation):
    def __init__(self, rate=0.1, **kwargs):
        super().__init__(**kwargs)
        self.rate = rate

    def _do(self, problem, X, *args, **kwargs):
        return X


not_one = 3
'''

Install = Callable[[str], None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Put a package with announcements where Python finds it."""

    def forget() -> None:
        algorithms.cache_clear()
        operators.cache_clear()

    def put(announcements: str) -> None:
        installed(tmp_path, "greedy_search", CODE, announcements, package="greedy")
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.delitem(sys.modules, "greedy_search", raising=False)
        forget()

    yield put
    forget()


def test_an_announced_algorithm_is_made_by_its_name_with_its_settings(install):
    install("[robolaser.algorithms]\ngreedy = greedy_search:Greedy\n")
    made = algorithm_named("greedy:pop_size=30")
    assert (type(made).__name__, made.pop_size) == ("Greedy", 30)
    with pytest.raises(UsageError, match=r"greedy has no setting 'popsize'\. Did you mean 'pop_size'"):
        algorithm_named("greedy:popsize=30")


def test_an_announced_algorithm_is_a_solver_but_takes_part_only_where_it_is_named(install):
    install("[robolaser.algorithms]\ngreedy = greedy_search:Greedy\n")
    assert solver_titles()["greedy"] == "Differential evolution around the best"
    assert find("greedy:pop_size=30").title == "Differential evolution around the best"
    assert "greedy" not in DEFAULT


def test_an_announced_operator_is_chosen_by_its_name_with_its_settings(install):
    install("[robolaser.operators.mutation]\nflip = greedy_search:Flip\n")
    mutation = algorithm_named("ga:mutation=flip:mutation.rate=0.5").mating.mutation
    assert (type(mutation).__name__, mutation.rate) == ("Flip", 0.5)


@pytest.mark.parametrize(
    ("announcement", "reason"),
    [
        ("[robolaser.algorithms]\nrcga = greedy_search:Greedy\n", "but robolaser has one of that name"),
        ("[robolaser.algorithms]\nnothing = greedy_search:not_one\n", "it is 3, not a subclass of Algorithm"),
        ("[robolaser.operators.crossover]\nflip = greedy_search:Flip\n", "not a subclass of Crossover"),
    ],
)
def test_an_announcement_that_cannot_be_used_is_named_with_its_package(install, announcement, reason):
    install(announcement)
    with pytest.raises(PluginError, match=f"greedy.*{reason}"):
        algorithm_named("ga:crossover=SBX" if "operators" in announcement else "rcga")


def test_without_other_packages_there_are_our_algorithms():
    assert algorithms() == ALGORITHMS
