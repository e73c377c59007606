"""Elites stay, the rest gives way to its offspring."""

import numpy as np
import pytest
from bowl import Bowl, population
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.nsga3 import NSGA3
from pymoo.algorithms.moo.rvea import RVEA
from pymoo.algorithms.moo.spea2 import SPEA2
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.ga_niching import NicheGA
from pymoo.optimize import minimize
from pymoo.problems import get_problem
from pymoo.util.ref_dirs import get_reference_directions

from robolaser.errors import AlgorithmError
from robolaser.operators import ElitistReplacement, RouletteSelection
from robolaser.operators.elitist_replacement import survivors

PARENTS = np.array([5.0, 1.0, 3.0, 2.0])


def test_the_best_parents_and_all_offspring_survive():
    assert survivors(PARENTS, np.array([9.0, 8.0]), 2, 4).tolist() == [1, 3, 4, 5]


def test_offspring_in_excess_are_left_out_from_the_worst():
    assert survivors(PARENTS, np.array([9.0, 0.0, 7.0, 8.0]), 2, 4).tolist() == [1, 3, 5, 6]


def test_missing_offspring_are_made_up_for_by_parents():
    assert survivors(PARENTS, np.array([9.0]), 2, 4).tolist() == [1, 3, 2, 4]


def test_without_elites_a_generation_gives_way_whole():
    assert survivors(PARENTS, np.full(4, 99.0), 0, 4).tolist() == [4, 5, 6, 7]


def test_of_equals_the_earlier_stays():
    assert survivors(np.ones(4), np.ones(4), 2, 4).tolist() == [0, 1, 4, 5]


def test_a_cost_that_is_not_a_number_is_no_elite(problem):
    pop = population(8)
    pop.set("F", np.array([np.nan, 3.0, np.inf, 1.0, 9.0, 9.0, 9.0, 9.0])[:, None])
    kept = ElitistReplacement(2).do(problem, pop, n_survive=4, random_state=np.random.default_rng(0))
    assert kept.get("F")[:, 0].tolist() == [1.0, 3.0, 9.0, 9.0]


def test_a_negative_number_of_elites_is_refused():
    with pytest.raises(AlgorithmError, match="n_elites is -1"):
        ElitistReplacement(-1)


def test_with_several_objectives_elites_are_of_the_first_front():
    algorithm = NSGA2(pop_size=12, survival=ElitistReplacement(3), selection=RouletteSelection())
    F = minimize(Bowl(n_obj=2), algorithm, ("n_gen", 5), seed=1).pop.get("F")
    assert not any(np.all(other <= elite) and np.any(other < elite) for elite in F[:1] for other in F[:3])


@pytest.mark.parametrize(
    ("algorithm", "problem"), [(NSGA2, "zdt1"), (SPEA2, "zdt1"), (NSGA3, "zdt1"), (RVEA, "zdt1"), (NicheGA, "sphere")]
)
def test_an_algorithm_that_reads_its_own_survival_is_refused_by_name(algorithm, problem):
    first = [get_reference_directions("uniform", 2, n_partitions=6)] if algorithm in (NSGA3, RVEA) else []
    with pytest.raises(AlgorithmError, match=f"ElitistReplacement cannot serve {algorithm.__name__}"):
        minimize(get_problem(problem), algorithm(*first, survival=ElitistReplacement(2)), ("n_gen", 3), seed=1)


def test_parents_are_the_population_of_the_algorithm_however_few():
    start = np.random.default_rng(1).uniform(0, 1, (5, 4))
    algorithm = GA(pop_size=20, sampling=start, survival=ElitistReplacement(2), eliminate_duplicates=False)
    algorithm.setup(get_problem("sphere", n_var=4), termination=("n_gen", 3), seed=1)
    algorithm.next()
    parents = list(algorithm.pop)
    algorithm.next()
    assert sum(any(one is parent for parent in parents) for one in algorithm.pop) == 2
