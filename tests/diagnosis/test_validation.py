"""What is found on one campaign is to predict another one of the same arm."""

import json
from dataclasses import replace

import numpy as np
import pytest
from asked import simulate_as_asked
from few_files import untried

from robolaser.cli import main
from robolaser.data.joining import check_same_arm
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.diagnosis.summary_text import transfer_sentence
from robolaser.errors import DataError
from robolaser.model.effects import EFFECTS
from robolaser.model.forward_model import Model
from robolaser.parameters import Parameter
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

OFFSET = {"joint_offset:joint_3": 0.004}
OFFSETS = [kind for kind in EFFECTS if kind.name == "joint_offset"]


def campaign(seed, *, effects=OFFSET, kind="point", robot="scorbot_er7", poses=16, **options):
    """A campaign with a tracker and tools of its own: each seed sets them up anew."""
    made = simulate_as_asked(
        find_robot(robot), kind=kind, poses=poses, noise=Noise(point_m=2e-5), effects=effects, seed=seed, **options
    )
    return replace(made.dataset, name=f"campaign-{seed}")


@pytest.fixture(scope="module")
def found():
    return examine(campaign(1), OFFSETS, seed=1, validate=[campaign(2)])


def test_an_effect_of_the_arm_carries_over_to_where_base_and_tool_stand_elsewhere(found):
    (validation,) = found.validation
    assert validation.is_better
    assert validation.nominal_m == validation.calibrated_m > 3e-4
    assert validation.after_m < 1.3 * validation.noise_floor_m
    assert validation.rows == 48
    assert "It transfers to campaign-2: there the error falls from" in found.sentence


def test_an_arm_that_was_repaired_in_between_is_said_not_to_be_predicted():
    repaired = examine(campaign(1), OFFSETS, seed=1, validate=[campaign(2, effects={})])
    (validation,) = repaired.validation
    assert not validation.is_better
    assert validation.after_m > validation.calibrated_m
    assert "It does not transfer to campaign-2: the error there is" in repaired.sentence


def test_gross_errors_of_the_other_campaign_are_left_out_and_counted():
    spoilt = campaign(2, effects=OFFSET | {"outliers": 0.05})
    (validation,) = examine(campaign(1), OFFSETS, seed=1, validate=[spoilt]).validation
    assert validation.after_m < 1.3 * validation.noise_floor_m
    assert validation.rows < 48
    assert any("are gross errors" in remark for remark in validation.remarks)


def test_without_effects_the_sentence_states_the_one_error_there_is(found):
    (validation,) = found.validation
    said = transfer_sentence(validation, has_effects=False)
    assert said.startswith("On campaign-2, predicted with the same model, the error is")


def test_what_closes_less_than_half_of_another_gap_hardly_carries_over(found):
    (validation,) = found.validation
    worse = replace(validation, calibrated_m=18e-3, after_m=17.2e-3, noise_floor_m=1.75e-5, is_better=True)
    assert transfer_sentence(worse, has_effects=True).startswith(
        "Little of it transfers to campaign-2: there the error"
    )
    half = replace(worse, after_m=12.7e-3)
    assert transfer_sentence(half, has_effects=True).startswith("It transfers to campaign-2")


def test_a_scanner_is_transferred_with_its_own_parameters():
    """A stripe scanner's fourteen parameters stay as found; nothing but an unplaced target is fitted anew."""
    noise = {"noise": Noise(pixel_px=0.05)}
    whole = simulate_as_asked(find_robot("scorbot_er7"), poses=12, placed=False, seed=3, **noise).dataset
    here = np.arange(len(whole.poses)) % 3 != 0
    validation = examine(whole.of_poses(here), OFFSETS, seed=1, validate=[whole.of_poses(~here)]).validation[0]
    assert validation.nominal_m > 5 * validation.calibrated_m
    assert validation.after_m < 2 * validation.noise_floor_m


def test_what_drifted_is_taken_as_at_the_end_of_its_run_and_said_so():
    """The arm has warmed up on the first campaign; the second is taken as measured warm, which it was not."""
    drift = {"thermal_drift:joint_3": 0.003}
    warm_up = [kind for kind in EFFECTS if kind.name == "thermal_drift"]
    first, second = campaign(1, effects=drift, poses=24), campaign(2, effects=drift, poses=24)
    (validation,) = examine(first, warm_up, seed=1, validate=[second]).validation
    assert any(remark.startswith("thermal_drift at joint_3: how far it has come") for remark in validation.remarks)


def test_campaigns_with_sessions_predict_and_are_predicted():
    both = simulate(
        find_robot("scorbot_er7"), kind="point", poses=10, noise=Noise(point_m=2e-5), effects=OFFSET,
        options=CellOptions(sessions=2), seed=5,
    ).dataset  # fmt: skip
    bounds = Parameter("base.x@session-1", "m", 2.5, 0.0, 5.0)
    both = replace(both, parameters={bounds.name: bounds})
    for here, there in ((both, campaign(2)), (campaign(2), both)):
        (validation,) = examine(here, OFFSETS, seed=1, validate=[there]).validation
        assert validation.after_m < 1.3 * validation.noise_floor_m


@pytest.fixture(scope="module")
def monday():
    """A campaign before a standing camera."""
    return simulate(
        find_robot("ur5"), kind="camera", poses=20, points=15, noise=Noise(pixel_px=0.05),
        options=CellOptions(mount="base", placed=False), seed=3,
    )  # fmt: skip


def on_friday(made, **moved_by: float):
    """The same seen once more with camera or board moved."""
    dataset, model = made.dataset, Model(made.dataset)
    there = {name: made.truth[name] + moved_by.get(name, 0.0) for name in model.parameters.names}
    here, there = ({name: np.array([value]) for name, value in one.items()} for one in (made.truth, there))
    moves = model.residuals_at(here)[0] - model.residuals_at(there)[0]
    points = replace(dataset.points, pixel=dataset.points["pixel"] + moves)
    return replace(dataset, name="friday", points=points, parameters={})


@pytest.mark.parametrize("what", ["hand_eye.x", "target.x"])
def test_a_standing_camera_and_its_board_may_both_be_put_elsewhere(monday, what):
    here = replace(monday.dataset, parameters={})
    (validation,) = examine(here, OFFSETS, seed=1, validate=[on_friday(monday, **{what: 0.004})]).validation
    assert validation.after_m < 1.3 * validation.noise_floor_m
    assert validation.after_m < 5e-4


def other_arm():
    arm = find_robot("scorbot_er7")
    moved = arm.placements.copy()
    moved[2, 0, 3] += 1e-3
    return arm.with_placements(moved)


@pytest.mark.parametrize(
    ("other", "differs"),
    [
        (lambda: campaign(2, robot="panda", effects={}), "[robot] joints are"),
        (lambda: replace(campaign(2), robot=other_arm()), "their URDFs place joint_3 differently"),
        (lambda: campaign(2, kind="socket"), '[sensor] kind is "point" in campaign-1 and "socket" in campaign-2'),
        (lambda: replace(campaign(2), robot=None), "only campaign-1 has a [robot]"),
    ],
)
def test_another_arm_or_sensor_is_refused_with_what_differs(other, differs):
    with pytest.raises(DataError, match="campaign-2 cannot be predicted") as refused:
        check_same_arm(campaign(1), other(), "predicted")
    assert differs in str(refused.value)


def test_the_command_writes_the_validation_and_shows_it_on_the_page(tmp_path, capsys):
    for seed in (1, 2):
        save(campaign(seed), tmp_path / f"campaign-{seed}")
    typed = ["diagnose", str(tmp_path / "campaign-1"), "--output", str(tmp_path / "why"), "--quiet"]
    with untried():
        assert main([*typed, "--validate", str(tmp_path / "campaign-2")]) == 0
    (validation,) = json.loads((tmp_path / "why" / "diagnosis.json").read_text())["validation"]
    assert validation["dataset"] == "campaign-2"
    assert validation["after_mm"] < validation["calibrated_mm"]
    assert "Other data of the same arm" in (tmp_path / "why" / "report.html").read_text()
    save(campaign(2, kind="socket"), tmp_path / "sockets")
    capsys.readouterr()
    assert main([*typed, "--force", "--validate", str(tmp_path / "sockets")]) == 1
    assert "cannot be predicted" in capsys.readouterr().err
