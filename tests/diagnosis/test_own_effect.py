"""An effect that a script brings is suspected like ours, found, reported, and part of the corrected model."""

from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np
import pytest

import robolaser
from robolaser.arrays import Array
from robolaser.calibration.result import as_json
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.corrected_model import corrected
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.model.effects.effect import Effect, Run, nonlinear, parameter
from robolaser.model.stages import Stage
from robolaser.report.diagnosis.page import document
from robolaser.report.page import render
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate

COUPLING = 0.004


@final
@dataclass(frozen=True)
class JointCoupling(Effect):
    """The joint before drags this one along."""

    name: ClassVar[str] = "joint_coupling"
    title: ClassVar[str] = "dragged along by the joint before it"
    reference: ClassVar[str] = "belts that run over the shoulder to the elbow"
    stage: ClassVar[Stage] = Stage.JOINTS

    coupling: Array = parameter(unit="", bound=0.1, prior_scale=2e-3)
    slip: Array = nonlinear(unit="", lower=0.0, upper=1.0, nominal=0.0)

    @classmethod
    def sites(cls, robot: Robot | None) -> tuple[str, ...]:
        return robot.joints[1:] if robot else ()

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        return np.linspace(0.0, 1.0, 3)[:, None]

    def apply(self, value: Array, run: Run, /) -> Array:
        joint = run.robot.joints.index(self.where)
        bent = value.repeat(len(self.coupling), axis=0) if len(value) == 1 else value.copy()
        bent[:, :, joint] += self.coupling[:, None] * (1 - self.slip[:, None]) * value[:, :, joint - 1]
        return bent


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    noise = Noise(point_m=2e-5)
    cell = simulate(robolaser.find_robot("scorbot_er7"), kind="point", poses=40, noise=noise, seed=1).dataset
    read = cell.poses.q.copy()
    read[:, 2] -= COUPLING * read[:, 1]
    cell = replace(cell, poses=replace(cell.poses, q=read))
    return examine(cell, [*robolaser.EFFECTS, JointCoupling], seed=1)


def test_it_explains_what_it_causes(diagnosis: Diagnosis) -> None:
    said = diagnosis_json(diagnosis)
    assert said["verdict"] == "explained"
    assert [(one["effect"], one["where"]) for one in said["effects"]] == [("joint_coupling", "joint_3")]


@final
@dataclass(frozen=True)
class LaggingArm(Effect):
    """All joints lag behind by a share of what they have turned, from some angle of the last one on."""

    name: ClassVar[str] = "lagging_arm"
    title: ClassVar[str] = "lags from some angle on"
    reference: ClassVar[str] = "made up"
    stage: ClassVar[Stage] = Stage.JOINTS
    site: ClassVar[str] = "timing"

    lag: Array = parameter(unit="", bound=0.1, prior_scale=2e-3)
    begin: Array = nonlinear(unit="rad", lower=-3.0, upper=3.0, nominal=0.0)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        return np.linspace(-3.0, 3.0, 60)[:, None]

    def apply(self, value: Array, run: Run, /) -> Array:
        return value + self.lag[:, None, None] * value * (value[:, :, -1:] > self.begin[:, None, None])


def test_an_effect_of_all_joints_with_many_nonlinear_values_is_tried() -> None:
    noise = Noise(point_m=2e-5)
    cell = simulate(robolaser.find_robot("scorbot_er7"), kind="point", poses=40, noise=noise, seed=1).dataset
    q = cell.poses.q
    read = q / (1.0 + 0.01 * (q[:, -1:] > 0.5))
    found = examine(replace(cell, poses=replace(cell.poses, q=read)), [LaggingArm], seed=1)
    assert [str(one.candidate_effect) for one in found.findings] == ["lagging_arm at timing"]


def test_its_title_stands_in_the_report(diagnosis: Diagnosis) -> None:
    assert "dragged along by the joint before it" in render(document(diagnosis), "robolaser diagnose")


def test_it_is_part_of_the_corrected_model(diagnosis: Diagnosis) -> None:
    (entry,) = as_json(corrected(diagnosis, 1))["effects"]
    numbers = {name: number["value"] for name, number in entry["parameters"].items()}
    assert numbers["coupling"] * (1 - numbers["slip"]) == pytest.approx(COUPLING, rel=0.02)
