from functools import cached_property
from itertools import product
from time import process_time

import numpy as np
import pytest

from robolaser.calibration.result import rms
from robolaser.data.dataset import Noise
from robolaser.diagnosis.averaging import Observed
from robolaser.diagnosis.held_out_gap import folds, held_out
from robolaser.diagnosis.pareto_front import front, question, searched, stepwise, undominated
from robolaser.diagnosis.penalized_fit import Problem
from robolaser.diagnosis.score_tests import library, signatures
from robolaser.diagnosis.verdict import price
from robolaser.estimation.jacobian import jacobian
from robolaser.geometry.robots import find_robot
from robolaser.model.effects import EFFECTS
from robolaser.model.forward_model import Model
from robolaser.simulation import simulate

BENT = {
    "stripe": {"joint_compliance:joint_2": 1e-4, "encoder_eccentricity:joint_3": 3e-3},
    "point": {"backlash:joint_3": 2e-3, "encoder_scale:joint_2": 3e-3},
    "socket": {"encoder_eccentricity:joint_2": 3e-3},
}


class Case:
    def __init__(self, kind, *, poses=24, points=6, effects=None):
        noise = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5, point_m=2e-5)
        points = points if kind == "stripe" else 3
        self.simulated = simulate(
            find_robot("scorbot_er7"), kind=kind, poses=poses, points=points, noise=noise, effects=effects, seed=3
        )
        raw = self.simulated.dataset
        observed = Observed.of(raw)
        model = Model(observed.dataset)
        x = model.parameters.nominal
        self.fitted = Problem.of(model, observed.noise(model, x, jacobian(model, x), raw)).fit(x)
        self.signatures = signatures(self.fitted, library(EFFECTS, raw))
        self.folds = folds(observed, 0)

    @cached_property
    def leaders(self):
        return [self.signatures[i] for i in stepwise(self.fitted, self.signatures)]

    @cached_property
    def problem(self):
        fold = self.folds[self.fitted.problem.model.dataset.points.pose]
        return question(self.fitted, self.leaders, fold)

    @cached_property
    def front(self):
        return self.again(1)

    def again(self, seed):
        return front(self.fitted, self.signatures, self.folds, seed)


@pytest.fixture(scope="module", params=list(BENT))
def bent(request):
    return Case(request.param, effects=BENT[request.param])


@pytest.fixture(scope="module")
def stripe():
    return Case("stripe", effects=BENT["stripe"])


def test_the_front_falls_with_every_effect_and_starts_without_any(bent):
    found = bent.front
    assert found[0].effects == ()
    counts, gaps = [len(choice.effects) for choice in found], [choice.gap_m for choice in found]
    assert counts == sorted(set(counts))
    assert (np.diff(gaps) < 0).all()


def test_without_effects_the_gap_is_that_of_refitted_folds(bent):
    expected = rms(held_out(bent.fitted, bent.folds))
    assert bent.front[0].gap_m == pytest.approx(expected, rel=0.03)


def test_the_true_effects_or_as_good_ones_are_on_the_front(bent):
    true = bent.simulated.effects
    chosen = next(choice for choice in bent.front if len(choice.effects) == len(true))
    assert chosen.gap_m < 0.5 * bent.front[0].gap_m
    if bent.simulated.dataset.kind != "socket":
        assert set(chosen.effects) == set(true)


def test_the_front_is_nowhere_worse_than_adding_one_effect_after_the_other(bent):
    n = len(bent.leaders)
    greedy = bent.problem.unseen(np.tri(n + 1, n, -1, dtype=bool))
    found = bent.front
    for count, gap in enumerate(greedy):
        assert min(choice.gap_m for choice in found if len(choice.effects) <= count) <= gap * (1 + 1e-12)


def test_the_search_misses_hardly_anything_of_what_all_sets_offer(stripe):
    problem = stripe.problem
    n = len(problem.names)

    def best(sets):
        F = problem.evaluate(problem.settled(np.hstack([sets * 1.0, np.zeros((len(sets), len(problem.reach)))])))
        return np.array([F[F[:, 1] <= count, 0].min() for count in range(n + 1)])

    every = np.array(list(product([False, True], repeat=n)))
    assert best(searched(problem, 1)) == pytest.approx(best(every), rel=1e-2)


def test_one_seed_gives_one_front(stripe):
    assert stripe.again(5) == stripe.again(5)


def test_where_nothing_departs_no_effect_buys_much():
    found = Case("stripe").front
    assert found[-1].gap_m > 0.95 * found[0].gap_m


def test_without_suspects_the_front_is_one_point(stripe):
    (only,) = front(stripe.fitted, [], stripe.folds, 1)
    assert only.effects == ()
    assert only.gap_m == pytest.approx(rms(held_out(stripe.fitted, stripe.folds)))


def test_few_suspects_are_no_less_tried(stripe):
    two = [one for one in stripe.signatures if one.candidate_effect in stripe.simulated.effects]
    found = front(stripe.fitted, two, stripe.folds, 1)
    assert set(found[-1].effects) == {one.candidate_effect for one in two}


def test_each_effect_taken_is_the_one_that_explains_most_beside_those_before(stripe):
    order = stepwise(stripe.fitted, stripe.signatures, most=4)
    assert len(order) == len(set(order)) == 4
    for i in range(4):
        before = [stripe.signatures[j].basis for j in order[:i]]

        def worth(one, before=before):
            columns = np.hstack([*before, one.basis])
            return -left(columns, one.against.rest) - price(one.candidate_effect, one.tried)

        others = [one for j, one in enumerate(stripe.signatures) if j not in order[:i]]
        assert worth(stripe.signatures[order[i]]) >= max(map(worth, others)) - 1e-2


def left(columns, rest):
    return ((rest - columns @ np.linalg.lstsq(columns, rest, rcond=1e-5)[0]) ** 2).sum()


def test_only_what_no_simpler_set_beats_is_undominated():
    assert undominated(np.array([0, 1, 1, 2, 3]), np.array([5.0, 4.0, 3.0, 3.0, 1.0])) == [0, 2, 4]


def test_a_front_of_sixty_poses_takes_less_than_a_second():
    case = Case("stripe", poses=60, points=10, effects=BENT["stripe"])
    start = process_time()
    case.again(1)
    assert process_time() - start < 1.0
