"""Two stripe scanners on one flange: what is wrong with one of them is named as its own."""

from dataclasses import replace

import numpy as np
import pytest
from several import together

from robolaser.data.dataset import Dataset
from robolaser.diagnosis import examine
from robolaser.diagnosis.cause_words import named, place
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.stage_derivatives import StageDerivatives
from robolaser.estimation.noise_estimate import noise_of
from robolaser.model.effects import EFFECTS, candidate_effects
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.stripe_bias import StripeBias
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.parameters import Parameter
from robolaser.robot.by_name import find_robot
from robolaser.trials.building import IMAGE_PX, Ranges, build, in_sight
from robolaser.trials.synthetic.fault_models.scanner import ProjectorRoll

ROLL = 0.01
NAMES = ("laser_roll", "laser_curvature", "laser_drift", "stripe_bias", "joint_offset")
FEW = Ranges(poses=(20, 20), points=(6, 6))


def narrower(item: Parameter) -> Parameter:
    """Within a quarter of its bounds: a search that is not in question is soon over."""
    to = 0.25
    lower, upper = (item.nominal + to * (end - item.nominal) for end in (item.lower, item.upper))
    return replace(item, lower=lower, upper=upper)


@pytest.fixture(scope="module")
def cell() -> Dataset:
    """`left` has its stripe along u, `right` along v, beside it; only the right one's projector is rolled."""
    left = build(find_robot("ur10"), FEW, np.random.default_rng(5), moving=False)
    aside = {"t_x": 0.03, "t_y": -0.02, "psi": 0.1}
    eye = left.cell.eye
    moved = {name: value + aside.get(name, 0.0) for name, value in eye.truth.items()}
    drawn = {
        name: replace(item, nominal=item.nominal + by, lower=item.lower + by, upper=item.upper + by)
        for name, item in left.blank.parameters.items()
        for by in (aside.get(name, 0.0),)
    }
    seen = in_sight(replace(left.cell, eye=replace(eye, truth=moved, stripe_axis="v")), IMAGE_PX)
    right = replace(left, cell=seen, blank=replace(left.blank, stripe_axis="v", parameters=drawn))
    one, other = (
        built.read(faults, np.random.default_rng(seed))
        for seed, (built, faults) in enumerate([(left, ()), (right, (ProjectorRoll("laser", ROLL),))])
    )
    both = together(one, {"left": (one, one.points), "right": (other, other.points)})
    return replace(
        both,
        members=tuple(replace(member, camera=member.name) for member in both.members),
        parameters={
            f"{side}.{name}": narrower(replace(item, name=f"{side}.{name}"))
            for side, dataset in (("left", one), ("right", other))
            for name, item in dataset.parameters.items()
        },
    )


def test_a_sensor_of_which_one_row_is_left_passes_it_beside_the_others(cell: Dataset) -> None:
    left, right = cell.sensors
    few = replace(cell, points=cell.points.take(np.sort(np.r_[left.rows, right.rows[:1]])))
    model = Model(few).sharing(Model(cell).parameters)
    x = model.parameters.nominal
    passed = StageDerivatives(Fit(problem_of(model, noise_of(model, x), model.parameters), x)).passing(Stage.PIXELS)
    assert passed.shape == few.points["pixel"].shape


def test_the_right_ones_laser_roll_is_named(cell: Dataset) -> None:
    found = examine(cell, [kind for kind in EFFECTS if kind.name in NAMES], seed=0)
    assert [str(one.candidate_effect) for one in found.findings] == ["laser_roll at right.laser"]
    angle = found.findings[0].parameters["angle"]
    assert abs(angle.value) == pytest.approx(ROLL, abs=5 * angle.std)
    assert found.where[0].site == "right.laser"
    assert "the laser plane is rolled against the image (right)" in found.sentence


@pytest.mark.parametrize("effect", ["laser_roll", "stripe_bias", "laser_curvature", "radial_distortion"])
def test_an_effect_of_one_scanner_moves_its_rows_alone(cell: Dataset, effect: str) -> None:
    _, right = candidate_effects([effect], cell)
    assert right.where in ("right.laser", "right.camera")
    model, plain = Model(cell, (right,)), Model(cell)
    values = plain.parameters.values(plain.parameters.nominal[None])
    amplitudes = {right.key(one.name): np.array([one.prior_scale]) for one in right.effect.amplitudes()}
    moved = np.abs(model.residuals_at({**values, **amplitudes}) - plain.residuals_at(values))[0].max(axis=1)
    rights = cell.points.sensor == 1
    assert (moved[~rights] == 0.0).all()
    assert (moved[rights] > 0.0).mean() > 0.9


def test_an_effect_stays_at_its_scanner_where_the_others_rows_are_gross_errors(cell: Dataset) -> None:
    own, other = (np.flatnonzero(cell.points.sensor == number) for number in (0, 1))
    left = replace(cell, points=cell.points.take(np.sort(np.append(own, other[:2]))))
    (bias,) = (one for one in candidate_effects([StripeBias], cell) if one.where == "left.laser")
    assert bias.where not in StripeBias.locations(left)  # two points are no plane
    model = Model(left, (bias,))
    values = model.parameters.values(model.parameters.nominal[None])
    moved = model.residuals_at({**values, bias.key("slope"): np.ones(1)})[0] != model.residuals_at(values)[0]
    np.testing.assert_array_equal(moved.any(axis=1), left.points.sensor == 0)


def test_each_scanners_stripe_runs_along_its_own_axis(cell: Dataset) -> None:
    rights = cell.points.sensor == 1
    across = Model(cell).run.across_stripe
    assert (across[~rights] == [0.0, 1.0]).all()
    assert (across[rights] == [1.0, 0.0]).all()


def test_sites_of_sensors_are_told_by_their_names() -> None:
    roll = next(kind for kind in EFFECTS if kind.name == "laser_roll")
    assert place("right.laser") == "laser of right"
    assert place("laser") == "laser"
    assert named(CandidateEffect(roll, "right.laser")) == "laser roll of right"
