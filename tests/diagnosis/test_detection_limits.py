"""From which size on an effect would have been found, and from which on it can be told from its rivals."""

from dataclasses import replace

import numpy as np
import pytest
from board_cell import begun, cell
from worlds import kinds

from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.detection_limits import detection_limits
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.result import DetectionLimit
from robolaser.diagnosis.score_tests import score_tests
from robolaser.diagnosis.selection import select
from robolaser.model.effects import candidate_effects
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def test_an_effect_shows_above_its_limit_and_not_below(clean):
    _, fitted = clean
    (score,) = score_tests(fitted, candidate_effects(["joint_offset:joint_3"], fitted.model.dataset))
    (limit,) = detection_limits([score])
    sizes = 1.8 * limit.size, 0.3 * limit.size
    above, below = (_search(cell({"joint_offset:joint_3": size}, seed=11)) for size in sizes)
    assert above.effects
    assert not below.effects


def limits_of(fitted: Fit, *wanted: str) -> list[DetectionLimit]:
    return list(detection_limits(score_tests(fitted, candidate_effects(wanted, fitted.model.dataset))))


def test_an_effect_without_rival_is_identified_where_it_is_detected(clean):
    (limit,) = limits_of(clean[1], "joint_offset:joint_3")
    assert limit.rival is None
    assert limit.identifiable == limit.size


def test_beside_a_rival_an_effect_must_be_larger_to_be_told_apart(clean):
    gain, offset = limits_of(clean[1], "joint_offset:joint_3", "encoder_scale:joint_3")
    assert offset.rival == gain.candidate_effect
    assert gain.rival == offset.candidate_effect
    assert offset.identifiable / offset.size == pytest.approx(gain.identifiable / gain.size)
    assert offset.identifiable > offset.size


def test_what_explains_no_less_for_more_parameters_is_no_rival(clean):
    offset, geometry = limits_of(clean[1], "joint_offset:joint_3", "link_geometry:joint_3")
    assert offset.rival is None
    assert geometry.rival == offset.candidate_effect


def test_an_overlooked_effect_costs_at_the_tool_what_it_moves(clean):
    _, fitted = clean
    (limit,) = limits_of(fitted, "joint_offset:joint_1")
    radius = np.linalg.norm(fitted.model.dataset.flange()[:, :2, 3], axis=1)
    assert limit.at_tool_m == pytest.approx(limit.size * radius.mean(), rel=0.5)


def test_a_size_that_no_arm_has_is_none(clean):
    _, fitted = clean
    (test,) = score_tests(fitted, candidate_effects(["joint_offset:joint_3"], fitted.model.dataset))
    (usual,) = detection_limits([test])
    plausible = 10 * 1.7e-3

    def seen_less(share: float) -> DetectionLimit:
        (limit,) = detection_limits([replace(test, white=test.white * share, columns=test.columns * share)])
        return limit

    small = seen_less(usual.size / (0.99 * plausible))
    large = seen_less(usual.size / (1.01 * plausible))
    assert small.size == pytest.approx(0.99 * plausible)
    assert (large.size, large.identifiable, large.at_tool_m) == (None, None, None)


def test_what_an_effect_found_does_too_is_not_what_the_data_cannot_see(clean):
    _, start = clean
    last, offset, geometry = "joint_offset:joint_5", "joint_offset:joint_3", "link_geometry:joint_3"
    candidates = candidate_effects([last, offset, geometry], start.model.dataset)
    refits = Refits(start, candidates)
    alone = refits.score_tests(start)
    final = refits.refit(start, [test for test in alone if test.candidate_effect == candidates[2]])
    found = {str(one.candidate_effect): one for one in detection_limits(refits.score_tests(final), alone)}
    assert {name: (one.size is None, one.is_imitated) for name, one in found.items()} == {
        "joint_offset at joint_3": (True, True),
        "joint_offset at joint_5": (True, False),
    }


def test_what_merely_shows_a_little_less_than_alone_is_not_what_an_effect_found_does(clean):
    _, fitted = clean
    (test,) = score_tests(fitted, candidate_effects(["joint_offset:joint_3"], fitted.model.dataset))
    (usual,) = detection_limits([test])
    plausible = 10 * 1.7e-3
    alone, beside = (
        replace(test, white=test.white * share, columns=test.columns * share)
        for share in (usual.size / (0.99 * plausible), usual.size / (1.01 * plausible))
    )
    (limit,) = detection_limits([beside], [alone])
    assert (limit.size, limit.is_imitated) == (None, False)


def _search(dataset: Dataset) -> Fit:
    _, fitted = begun(dataset)
    return select(Refits(fitted, candidate_effects(["joint_offset", "encoder_scale"], fitted.model.dataset)))


def test_a_shape_that_moves_nothing_is_not_what_an_effect_found_does():
    """On an arm without masses some links bend under nothing: what rounding leaves of them fits noise as well."""
    noise = Noise(pixel_px=0.1, target_m=3e-5)
    made = simulate(find_robot("scorbot_er7"), poses=60, noise=noise, effects={"backlash:joint_2": 2e-3}, seed=1)
    found = examine(made.dataset, kinds("backlash", "link_compliance", "joint_offset", "settling"), seed=1)
    assert found.verdict == "explained"
    assert not [one for one in found.limits if one.is_imitated]
    assert "cannot distinguish" not in found.sentence
