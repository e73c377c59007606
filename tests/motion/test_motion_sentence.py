"""The verdict on a moving arm in words: what it says of errors and of how sure it is."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from robolaser.motion.calibration import MotionFit
from robolaser.motion.gap import KindGap
from robolaser.motion.result_json import _first, _shrinks, _surely, _up_to
from robolaser.report.motion import _figures


@pytest.mark.parametrize(("after", "said"), [(0.0123449, "is 0.0123 Nm"), (0.001, "falls from 0.0123 Nm to 0.001 Nm")])
def test_an_error_that_is_printed_alike_before_and_after_does_not_fall(after: float, said: str) -> None:
    error = np.array([0.012345])
    assert said in _shrinks(KindGap("torque", "Nm", error, error, np.array([after]), np.array([1e-4]), 100))


def test_torques_of_large_arms_have_no_powers_of_ten_and_as_many_digits_as_their_noise() -> None:
    before, after, noise = (np.array([size]) for size in (7062.0, 191.4, 190.8))
    said = _shrinks(KindGap("torque", "Nm", before, before, after, noise, 100))
    assert said == "the torque error falls from 7060 Nm to 191 Nm (noise 191 Nm)"


@pytest.mark.parametrize(("probability", "said"), [(0.95, ""), (0.6, "likely, "), (0.468, "perhaps, ")])
def test_what_is_no_likelier_than_not_is_not_called_likely(probability: float, said: str) -> None:
    assert _surely(probability) == said


@pytest.mark.parametrize(("noise", "said"), [(1e-4, " to 0.03°"), (2e-4, "")])
def test_an_arm_without_a_gap_whose_errors_are_more_than_noise_follows_up_to_a_size(noise: float, said: str) -> None:
    error = np.array([2e-4])
    assert _up_to([KindGap("tracking", "rad", error, error, error, np.array([noise]), 100)]) == said


def test_no_bar_is_longer_than_its_track_where_the_noise_is_the_largest() -> None:
    error, noise = np.array([1e-4]), np.array([3e-4])
    gap = KindGap("tracking", "rad", error, error, error, noise, 100)
    figures = _figures(cast("MotionFit", SimpleNamespace(gaps=(gap,), gap_mm={"after": None})))
    assert [figure.share for figure in figures] == pytest.approx([100 / 3, 100 / 3, 100])


def test_a_sentence_names_three_and_counts_the_others() -> None:
    assert _first(["a", "b", "c"], "; ", ", listed below") == "a; b; c"
    assert _first(["a", "b", "c", "d", "e"], "; ", ", listed below") == "a; b; c; and 2 more, listed below"
