from itertools import product

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.optimize import minimize

from robolaser.errors import AlgorithmError
from robolaser.operators import ArithmeticCrossover, NonUniformMutation
from robolaser.problems import Addition, BestAmplitudes, GapAgainstComplexity, Neighbourhood

ROWS, ORDINARY, FOLDS = 60, 4, 5
WIDTHS = (1, 2, 1, 3)
NOISE_M = 1e-4
TRUE = {0: np.array([1.5]), 1: np.array([0.7, -1.1])}


def linear_world(*, prior=1.0, far=0.0):
    """Residuals of noise and two true effects; whitened by the noise, priors beneath."""
    rng = np.random.default_rng(1)
    plain_slopes = 3e-3 * rng.normal(size=(ROWS, 3, ORDINARY))
    columns = [1e-3 * rng.normal(size=(ROWS, 3, a)) for a in WIDTHS]
    columns[2] = columns[2] + 2 * columns[0]
    plain = NOISE_M * rng.normal(size=(ROWS, 3)) - sum(columns[i] @ size for i, size in TRUE.items())

    def tall(of_rows, beneath):
        return np.concatenate([of_rows.reshape((3 * ROWS, *of_rows.shape[2:])) / NOISE_M, beneath])

    model = Neighbourhood(
        white=tall(plain, np.full(ORDINARY, far)),
        white_slopes=tall(plain_slopes, prior * np.eye(ORDINARY)),
        plain=plain,
        plain_slopes=plain_slopes,
        row=np.append(np.repeat(np.arange(ROWS), 3), np.full(ORDINARY, -1)),
    )
    additions = [
        Addition(f"effect {i}", tall(column, np.zeros((ORDINARY, a))), column, np.full(a, 10.0))
        for i, (a, column) in enumerate(zip(WIDTHS, columns, strict=True))
    ]
    return model, additions, np.arange(ROWS) % FOLDS


@pytest.fixture(scope="module")
def problem():
    return GapAgainstComplexity(*linear_world())


def candidates(problem, count=20):
    return np.random.default_rng(2).uniform(problem.xl, problem.xu, (count, problem.n_var))


def every_set(problem):
    sets = np.array(list(product([0.0, 1.0], repeat=len(problem.names))))
    return np.hstack([sets, np.zeros((len(sets), len(problem.reach)))])


def by_hand(world, chosen, amplitudes):
    """The gap by one least-squares fit after the other; amplitudes are fitted too where none are given."""
    model, additions, fold = world
    taken = [addition for addition, inside in zip(additions, chosen, strict=True) if inside]
    of_white = np.where(model.row < 0, -1, fold[model.row])
    squares = 0.0
    for k in np.unique(fold):
        seen, out = of_white != k, fold == k
        ordinary, white, error = model.white_slopes[seen], model.white[seen], model.plain[out]
        sizes = np.zeros(0)
        if amplitudes is None and taken:
            columns = np.hstack([addition.white[seen] for addition in taken])
            reach = np.concatenate([addition.reach for addition in taken])
            J = np.vstack([np.hstack([ordinary, columns]), np.eye(ORDINARY + len(reach))[ORDINARY:] / reach[:, None]])
            found = -np.linalg.lstsq(J, np.append(white, np.zeros(len(reach))), rcond=None)[0]
            moves, sizes = found[:ORDINARY], found[ORDINARY:]
        else:
            if taken:
                sizes = amplitudes
                white = white + np.hstack([addition.white[seen] for addition in taken]) @ sizes
            moves = -np.linalg.lstsq(ordinary, white, rcond=None)[0]
        error = error + model.plain_slopes[out] @ moves
        if taken:
            error = error + np.concatenate([addition.plain[out] for addition in taken], axis=-1) @ sizes
        squares += (error**2).sum()
    return np.sqrt(squares / ROWS)


@pytest.mark.parametrize("prior", [1.0, 0.0], ids=["priors", "no priors"])
def test_gaps_are_those_of_one_fit_after_the_other(prior):
    world = linear_world(prior=prior, far=0.3 * prior)
    problem = GapAgainstComplexity(*world)
    x = candidates(problem)
    chosen = problem.chosen(x)
    sizes = [x[i, len(WIDTHS) :][inside[problem.effect]] for i, inside in enumerate(chosen)]
    expected = [by_hand(world, *one) for one in zip(chosen, sizes, strict=True)]
    assert problem.evaluate(x)[:, 0] == pytest.approx(expected, rel=1e-9)


def test_unseen_gaps_are_those_of_fits_that_know_nothing_of_the_fold():
    world = linear_world(far=0.3)
    problem = GapAgainstComplexity(*world)
    sets = problem.chosen(every_set(problem))
    assert problem.unseen(sets) == pytest.approx([by_hand(world, chosen, None) for chosen in sets], rel=1e-9)


def test_complexity_is_the_number_of_effects_in_the_model(problem):
    x = every_set(problem)
    assert (problem.evaluate(x)[:, 1] == x[:, : len(WIDTHS)].sum(axis=1)).all()


def test_amplitudes_of_absent_effects_change_nothing(problem):
    x = candidates(problem)
    other = x.copy()
    other[:, len(WIDTHS) :][~problem.chosen(x)[:, problem.effect]] = 3.0
    assert np.array_equal(problem.evaluate(x), problem.evaluate(other))


def test_one_candidate_is_judged_as_in_a_population(problem):
    x = candidates(problem)
    alone = np.concatenate([problem.evaluate(one[None]) for one in x])
    assert alone == pytest.approx(problem.evaluate(x), rel=1e-12)


def test_no_other_amplitudes_make_a_settled_gap_much_smaller(problem):
    x = problem.settled(every_set(problem))
    assert (x >= problem.xl).all()
    assert (x <= problem.xu).all()
    rng = np.random.default_rng(3)
    for _ in range(20):
        moved = x.copy()
        moved[:, len(WIDTHS) :] += rng.normal(scale=0.03, size=(len(x), len(problem.reach)))
        assert (problem.evaluate(moved)[:, 0] >= problem.evaluate(x)[:, 0] * (1 - 1e-6)).all()


def test_settling_keeps_the_choice_and_settles_once(problem):
    x = problem.settled(candidates(problem))
    assert np.array_equal(problem.chosen(x), problem.chosen(candidates(problem)))
    assert np.array_equal(problem.settled(x), x)


def test_twins_among_the_effects_leave_every_gap_finite():
    model, additions, fold = linear_world()
    problem = GapAgainstComplexity(model, [*additions, *additions], fold)
    x = problem.settled(every_set(problem))
    assert np.isfinite(problem.evaluate(x)).all()
    assert np.isfinite(problem.unseen(problem.chosen(x))).all()


def test_the_true_effects_bring_the_gap_to_the_noise(problem):
    true = every_set(problem)[[0b1100]]
    floor = NOISE_M * np.sqrt(3)
    assert problem.evaluate(problem.settled(true))[0, 0] == pytest.approx(floor, rel=0.15)
    assert problem.unseen(problem.chosen(true))[0] == pytest.approx(floor, rel=0.15)
    assert problem.unseen(problem.chosen(every_set(problem)))[0] > 10 * floor


def test_amplitudes_that_saw_the_fold_promise_no_more_gap_than_those_that_did_not(problem):
    x = problem.settled(every_set(problem))
    assert (problem.evaluate(x)[:, 0] <= problem.unseen(problem.chosen(x)) * (1 + 1e-6)).all()


def test_any_multi_objective_algorithm_of_pymoo_finds_the_front(problem):
    algorithm = NSGA2(
        pop_size=30,
        crossover=ArithmeticCrossover(),
        mutation=NonUniformMutation(prob_var=0.2, b=1.0),
        repair=BestAmplitudes(),
    )
    found = minimize(problem, algorithm, ("n_gen", 15), seed=1)
    best = problem.evaluate(problem.settled(every_set(problem)))
    for count in range(3):
        reached = found.F[found.F[:, 1] <= count, 0].min()
        assert reached <= best[best[:, 1] == count, 0].min() * (1 + 1e-9)


def test_nothing_to_choose_from_is_refused():
    model, additions, fold = linear_world()
    with pytest.raises(AlgorithmError, match="one effect or more"):
        GapAgainstComplexity(model, [], fold)
    with pytest.raises(AlgorithmError, match="two folds or more"):
        GapAgainstComplexity(model, additions, np.zeros(ROWS, dtype=np.int64))
