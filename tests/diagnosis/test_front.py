from functools import cached_property
from itertools import combinations
from time import process_time

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.pareto_front import best_subsets, pareto_front, stepwise_order, undominated
from robolaser.diagnosis.pruning import nested_fits
from robolaser.diagnosis.refits import Refits, penalty
from robolaser.diagnosis.score_tests import library
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.noise_estimate import NoiseEstimate
from robolaser.model.effects import EFFECTS
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

PERTURBED = {
    "stripe": {"joint_compliance:joint_2": 1e-4, "encoder_eccentricity:joint_3": 3e-3},
    "point": {"backlash:joint_3": 2e-3, "encoder_scale:joint_2": 3e-3},
    "socket": {"encoder_eccentricity:joint_2": 3e-3},
}
NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5, point_m=2e-5)


class Case:
    def __init__(self, kind, *, poses=24, points=6, effects=None):
        points = points if kind == "stripe" else 3
        self.simulated = simulate(
            find_robot("scorbot_er7"), kind=kind, poses=poses, points=points, noise=NOISE, effects=effects, seed=3
        )
        raw = self.simulated.dataset
        data = AveragedData.of(raw)
        model = Model(data.dataset)
        x = model.parameters.nominal
        self.fit = Fit.of(problem_of(model, NoiseEstimate.of(data, model, x).for_weights(), model.parameters), x)
        self.refits = Refits(self.fit, library(EFFECTS, raw))
        self.held_out = HeldOut(self.fit, 0)

    @property
    def tests(self):
        return self.refits.score_tests(self.fit)

    @cached_property
    def front(self):
        return pareto_front(self.refits, [self.fit], self.held_out)


@pytest.fixture(scope="module", params=list(PERTURBED))
def perturbed(request):
    return Case(request.param, effects=PERTURBED[request.param])


@pytest.fixture(scope="module")
def stripe():
    return Case("stripe", effects=PERTURBED["stripe"])


def test_the_front_falls_with_every_effect_and_starts_without_any(perturbed):
    found = perturbed.front
    assert found[0].effects == ()
    counts, gaps = [len(point.effects) for point in found], [point.gap_m for point in found]
    assert counts == sorted(set(counts))
    assert (np.diff(gaps) < 0).all()


def test_each_gap_on_the_front_is_that_of_a_fit_without_each_fold(perturbed):
    for point in perturbed.front:
        tests = [test for test in perturbed.tests if test.candidate_effect in point.effects]
        fit = perturbed.refits.of(perturbed.fit, tests)
        assert point.gap_m == HeldOut(perturbed.fit, 0).gap(fit)


def test_the_true_effects_or_as_good_ones_are_on_the_front(perturbed):
    true = perturbed.simulated.effects
    chosen = next(point for point in perturbed.front if len(point.effects) == len(true))
    assert chosen.gap_m < 0.5 * perturbed.front[0].gap_m
    if perturbed.simulated.dataset.kind != "socket":
        assert set(chosen.effects) == set(true)


def test_one_set_of_effects_has_one_gap_throughout_a_diagnosis(perturbed):
    diagnosis = examine(perturbed.simulated.dataset, seed=0)
    gap_of = {frozenset(point.effects): point.gap_m for point in diagnosis.front}
    assert gap_of[frozenset()] == diagnosis.gap.calibrated_m
    added = frozenset()
    for found in diagnosis.findings:
        added |= {found.candidate_effect}
        assert gap_of.get(added, found.gap_after_m) == found.gap_after_m
    assert gap_of.get(added, diagnosis.gap.after_m) == diagnosis.gap.after_m


def test_the_front_is_nowhere_worse_than_the_chosen_effects_added_one_by_one(stripe):
    tests = [test for test in stripe.tests if test.candidate_effect in stripe.simulated.effects]
    nested = nested_fits(stripe.refits, stripe.refits.of(stripe.fit, tests), stripe.held_out)
    front = pareto_front(stripe.refits, nested, stripe.held_out)
    for count, fit in enumerate(nested):
        assert min(p.gap_m for p in front if len(p.effects) <= count) <= stripe.held_out.gap(fit)


def test_of_each_size_the_set_that_explains_most_is_found_exactly(stripe):
    tests = [stripe.tests[i] for i in stepwise_order(stripe.tests, most=6)]
    best = best_subsets(tests, most=3)
    for size in (1, 2, 3):
        sets = list(combinations(tests, size))
        most = max(explained(some) for some in sets)
        assert max(explained(some) for some in best if len(some) == size) == pytest.approx(most, rel=1e-9)


def explained(tests):
    columns = np.hstack([test.basis for test in tests])
    residuals = tests[0].against.at.r
    U, s, _ = np.linalg.svd(columns, full_matrices=False)
    return ((U[:, s > 1e-5].T @ residuals) ** 2).sum()


def test_where_nothing_departs_no_effect_gains_much():
    found = Case("stripe").front
    assert found[-1].gap_m > 0.95 * found[0].gap_m


def test_without_candidates_the_front_is_one_point(stripe):
    (only,) = pareto_front(Refits(stripe.fit, []), [stripe.fit], stripe.held_out)
    assert only.effects == ()
    assert only.gap_m == stripe.held_out.gap(stripe.fit)


def test_two_candidates_are_tried_alone_and_together(stripe):
    refits = Refits(stripe.fit, stripe.simulated.effects)
    found = pareto_front(refits, [stripe.fit], stripe.held_out)
    assert set(found[-1].effects) == set(stripe.simulated.effects)


def test_each_effect_taken_is_the_one_that_explains_most_beside_those_before(stripe):
    tests = stripe.tests
    order = stepwise_order(tests, most=4)
    assert len(order) == len(set(order)) == 4
    for i in range(4):
        before = [tests[j].basis for j in order[:i]]

        def net(one, before=before):
            return -left(np.hstack([*before, one.basis]), one.against.at.r) - penalty(one)

        others = [one for j, one in enumerate(tests) if j not in order[:i]]
        assert net(tests[order[i]]) >= max(map(net, others)) - 1e-2


def left(columns, residuals):
    return ((residuals - columns @ np.linalg.lstsq(columns, residuals, rcond=1e-5)[0]) ** 2).sum()


def test_only_what_no_simpler_set_beats_is_undominated():
    assert undominated(np.array([0, 1, 1, 2, 3]), np.array([5.0, 4.0, 3.0, 3.0, 1.0])) == [0, 2, 4]


def test_a_front_of_sixty_poses_takes_less_than_a_second():
    case = Case("stripe", poses=60, points=10, effects=PERTURBED["stripe"])
    assert case.tests
    start = process_time()
    assert pareto_front(case.refits, [case.fit], case.held_out)
    assert process_time() - start < 1.0
