"""Named, exported and predicted with is one model, without effects that do not help; each taken explains most."""

from dataclasses import replace
from functools import cached_property

import numpy as np
import pytest
from worlds import kinds

from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.corrected_model import corrected
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.pruning import prune
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.score_tests import library
from robolaser.diagnosis.thresholds import LEAST_PROBABILITY
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate
from robolaser.trials.building import Ranges, build
from robolaser.trials.synthetic.fault_models import FAULT_MODELS

SMALL, LARGE = ("hand_eye_sag", "hand_eye"), ("joint_coupling", "panda_joint4")
SIZES_M = {SMALL: 1e-3, LARGE: 2e-3}
FEW = kinds("hand_eye_sag", "joint_coupling")


def faulty() -> Dataset:
    """A scanner on an arm with two faults, of the trials' formulas."""
    rng = np.random.default_rng(5)
    built = build(find_robot("panda"), Ranges(poses=(40, 44)), rng, moving=False)
    return built.read([FAULT_MODELS[name].sample(where, SIZES_M[name, where], built.cell.run, rng)
                        for name, where in SIZES_M], rng)  # fmt: skip


class Faulty:
    """The same, both effects fitted."""

    @cached_property
    def refits(self) -> Refits:
        preparation = Preparation.of(faulty(), 0)
        effects = library(FEW, preparation.weighted.problem.model.dataset)
        return Refits(preparation.fit(effects), effects)

    @cached_property
    def both(self) -> Fit:
        tests = [test for test in self.refits.score_tests(self.refits.start) if place(test.candidate_effect) in SIZES_M]
        return self.refits.refit(self.refits.start, tests)


def place(one):
    return one.effect.name, one.where


class Gaps:
    """Held-out errors as told."""

    def __init__(self, gaps):
        self._gaps = gaps

    def misfit(self, fit):
        return self._gaps.get(frozenset(map(place, fit.effects)), 9.0)


@pytest.fixture(scope="module")
def cell():
    return Faulty()


def kept(cell, gaps):
    nested, evidence, _ = prune(cell.refits, cell.both, Gaps({frozenset(): 1.0, **gaps}))
    assert {place(one.candidate_effect) for one in evidence} == set(map(place, nested[-1].effects))
    return set(map(place, nested[-1].effects))


@pytest.mark.parametrize("spoils", [SMALL, LARGE])
def test_an_effect_that_raises_the_error_on_new_poses_is_in_no_model(cell, spoils):
    (other,) = SIZES_M.keys() - {spoils}
    gaps = {frozenset([other]): 0.5, frozenset([spoils]): 1.2, frozenset([SMALL, LARGE]): 0.6}
    assert spoils not in kept(cell, gaps)


def test_effects_that_each_lower_the_error_on_new_poses_stay(cell):
    gaps = {frozenset([SMALL]): 0.7, frozenset([LARGE]): 0.6, frozenset([SMALL, LARGE]): 0.5}
    assert kept(cell, gaps) == {SMALL, LARGE}


def test_an_effect_that_the_data_push_beyond_its_bound_is_in_no_model():
    made = simulate(find_robot("ur5"), kind="point", poses=20, noise=Noise(point_m=2e-5), seed=3).dataset
    scaled = replace(made, points=replace(made.points, xyz=1.03 * made.points["xyz"]))
    scales = kinds("tracker_scale")
    assert {item.upper for item in library(scales, scaled)[0].parameters.items} == {0.02}
    found = examine(scaled, effects=scales, seed=0)
    assert found.verdict == "unexplained"
    assert found.findings == found.model.effects == corrected(found, 0).model.effects == ()
    assert found.gap.after_m == found.gap.calibrated_m


def test_what_is_listed_is_what_is_exported_and_what_the_gap_is_of():
    others = kinds("joint_offset", "joint_compliance", "base_compliance", "encoder_eccentricity")
    found = examine(faulty(), FEW + others, seed=0)
    effects = set(found.model.effects)
    assert {one.candidate_effect for one in found.findings} <= effects
    assert all(one.probability >= LEAST_PROBABILITY and one.gap_after_m < one.gap_before_m for one in found.findings)
    assert found.findings[-1].gap_after_m == found.gap.after_m
    assert set(corrected(found, 0).model.effects) == effects
    assert {place(one) for one in effects} == set(SIZES_M)
