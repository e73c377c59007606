"""What every operator keeps to, whatever it does."""

import copy
import inspect
import pickle
import warnings

import numpy as np
import pytest
from bowl import LOWER, UPPER, Bowl, population, running
from pymoo.algorithms.moo.ctaea import CTAEA
from pymoo.algorithms.moo.moead import MOEAD
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.nsga3 import NSGA3
from pymoo.algorithms.moo.rvea import RVEA
from pymoo.algorithms.moo.sms import SMSEMOA
from pymoo.algorithms.moo.spea2 import SPEA2
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.ga_niching import NicheGA
from pymoo.core.crossover import Crossover
from pymoo.core.mutation import Mutation
from pymoo.core.parameters import get_params
from pymoo.core.selection import Selection
from pymoo.core.survival import Survival
from pymoo.core.variable import Real
from pymoo.optimize import minimize
from pymoo.util.ref_dirs import get_reference_directions

import robolaser.operators

FAMILY = [getattr(robolaser.operators, name) for name in robolaser.operators.__all__]
ROLES = {Crossover: "crossover", Mutation: "mutation", Selection: "selection", Survival: "survival"}


def role(kind):
    return next(name for base, name in ROLES.items() if issubclass(kind, base))


def act(operator, problem, pop, seed):
    """One call, as pymoo's algorithms make it; what comes out, as an array."""
    rng = np.random.default_rng(seed)
    told = {"random_state": rng, "algorithm": running(3)}
    match role(type(operator)):
        case "crossover":
            return operator.do(problem, pop, np.arange(len(pop)).reshape(-1, 2), **told).get("X")
        case "mutation":
            return operator.do(problem, pop, inplace=False, **told).get("X")
        case "selection":
            return operator.do(problem, pop, 10, 2, to_pop=False, **told)
        case _:
            return operator.do(problem, pop, n_survive=len(pop) // 2, **told).get("X")


@pytest.fixture(params=FAMILY, ids=lambda kind: kind.__name__)
def operator(request):
    return request.param()


def test_the_same_seed_gives_the_same_outcome(operator, problem, pop):
    assert np.array_equal(act(operator, problem, pop, 7), act(copy.deepcopy(operator), problem, pop, 7))


def test_it_travels_to_other_processes(operator, problem, pop):
    there = pickle.loads(pickle.dumps(operator))
    assert np.array_equal(act(there, problem, pop, 7), act(operator, problem, pop, 7))


def test_the_global_generator_plays_no_part(operator, problem, pop):
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    act(operator, problem, pop, 7)
    assert np.array_equal(before, np.random.get_state()[1])  # noqa: NPY002


def test_parents_are_left_as_they_were(operator, problem, pop):
    X, F = pop.get("X").copy(), pop.get("F").copy()
    act(operator, problem, pop, 7)
    assert np.array_equal(pop.get("X"), X)
    assert np.array_equal(pop.get("F"), F)


def test_children_stay_within_bounds(operator, problem, pop):
    if role(type(operator)) == "selection":
        pytest.skip("chooses, does not move")
    for seed in range(20):
        X = act(operator, problem, pop, seed)
        assert np.all((X >= LOWER) & (X <= UPPER))


def test_nothing_of_a_run_stays_behind(operator, problem, pop):
    before = copy.deepcopy(vars(operator))
    act(operator, problem, pop, 7)
    assert vars(operator).keys() == before.keys()
    assert not any(value is problem or hasattr(value, "n_iter") for value in vars(operator).values())


def test_probabilities_are_found_by_pymoos_tuning(operator):
    numbers = {
        name
        for name in inspect.signature(type(operator)).parameters
        if (name.startswith("prob") and name != "progress") or name == "b"
    }
    tunable = get_params(operator)
    assert numbers <= tunable.keys()
    assert all(isinstance(tunable[name], Real) for name in numbers)


def with_operator(algorithm, operator, **kwargs):
    accepted = {role(type(operator)): operator}
    return algorithm(**accepted, **kwargs)


def run(problem, algorithm, generations=6):
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="pymoo")
        once = minimize(problem, algorithm, ("n_gen", generations), seed=1)
        again = minimize(problem, algorithm, ("n_gen", generations), seed=1)
    X = once.pop.get("X")
    assert np.all((X >= LOWER) & (X <= UPPER))
    assert np.array_equal(X, again.pop.get("X"))
    return once


@pytest.mark.parametrize("shift", [0.0, -100.0], ids=["costs above 0", "costs below 0"])
@pytest.mark.parametrize("algorithm", [GA, NicheGA])
def test_it_works_alone_with_one_objective(operator, algorithm, shift):
    if algorithm is NicheGA and role(type(operator)) == "survival":
        pytest.skip("brings its own survival")
    found = run(Bowl(shift=shift), with_operator(algorithm, operator, pop_size=20))
    assert found.F[0] < np.median(Bowl(shift=shift).evaluate(population(Bowl(), 100).get("X")))


@pytest.mark.parametrize("algorithm", [NSGA2, NSGA3, SPEA2, SMSEMOA, RVEA, CTAEA])
def test_it_works_alone_with_several_objectives(operator, algorithm):
    if role(type(operator)) == "survival":
        pytest.skip("selects by what its own survival found out")
    if role(type(operator)) == "selection" and algorithm is CTAEA:
        pytest.skip("selects from two archives")
    if algorithm in (NSGA3, RVEA, CTAEA):
        directions = get_reference_directions("uniform", 2, n_partitions=11)
        run(Bowl(n_obj=2), with_operator(algorithm, operator, ref_dirs=directions))
    else:
        run(Bowl(n_obj=2), with_operator(algorithm, operator, pop_size=20))


def test_crossover_and_mutation_work_where_the_algorithm_hides_the_time(operator):
    if role(type(operator)) not in ("crossover", "mutation"):
        pytest.skip("MOEAD brings its own selection and survival")
    if role(type(operator)) == "mutation":
        operator = type(operator)(progress=0.5)
    directions = get_reference_directions("uniform", 2, n_partitions=11)
    run(Bowl(n_obj=2), with_operator(MOEAD, operator, ref_dirs=directions, n_neighbors=5))
