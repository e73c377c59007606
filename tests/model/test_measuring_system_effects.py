import numpy as np
import pytest

from robolaser import Plan, calibrate, find_robot
from robolaser.model.effects.run import Run
from robolaser.model.effects.tracker_scale import TrackerScale
from robolaser.simulation import simulate

SCALE = 3e-4


def test_a_tracker_that_reads_too_long_is_found_by_an_arm_whose_links_are_known() -> None:
    made = simulate(find_robot("ur5"), kind="point", poses=25, effects={"tracker_scale": SCALE}, seed=1)
    found = calibrate(made.dataset, Plan(effects=("tracker_scale",)))
    assert found.value("tracker_scale.measuring_system.scale") == pytest.approx(SCALE, rel=0.05)


def test_only_what_reads_lengths_has_a_scale() -> None:
    for kind, reason in (("stripe", "no lengths of its own"), ("socket", "target")):
        assert reason in TrackerScale.missing(simulate(find_robot("ur5"), kind=kind, poses=6, seed=1).dataset)


def test_lengths_that_read_too_long_are_shortened() -> None:
    points = np.random.default_rng(1).normal(size=(1, 5, 3))
    dataset = simulate(find_robot("ur5"), kind="point", poses=6, seed=1).dataset

    np.testing.assert_allclose(
        TrackerScale("measuring_system", np.array([SCALE])).apply(points, Run(dataset)) * (1 + SCALE), points
    )
