"""A sensor of the user's own in one file: a camera that sees the corners of a board, its rows two pixels each."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import ClassVar, Literal

import jsonschema
import numpy as np
import pytest

import robolaser
from robolaser.arrays import Array
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.result import as_json
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.sensor_format import PIXEL, XYZ, SensorFormat
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.effects import candidate_effects
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.forward_model import Model, jacobian
from robolaser.model.sensors.placements import motion, six_names
from robolaser.model.sensors.sensor import Sensor, SensorParameters
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameter, Values
from robolaser.report.error_analysis import ErrorAnalysis
from robolaser.robot.by_name import find_robot

INTRINSICS = ("fx", "fy", "cx", "cy", "k1")


@dataclass(frozen=True)
class Options:
    """Keys of [sensor]: where the camera sits; the board is at the other end."""

    mount: Literal["flange", "base"] = "flange"


class BoardCamera(Sensor):
    """A pinhole camera with one radial term, which sees points of a board."""

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="board_camera", title="camera", task="the camera sees corners",
        columns={"pixel": PIXEL, "xyz": XYZ}, numbers=2, unit="px", options=Options,
        units=dict.fromkeys(("fx", "fy", "cx", "cy"), "px"), positive=("fx", "fy"),
    )  # fmt: skip

    parameters = SensorParameters(free=(*INTRINSICS, *six_names("hand_eye"), *six_names("target")))

    def frames(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> tuple[Array, Array]:
        """T_base_camera and T_base_target at every pose, (c, n or 1, 4, 4)."""
        camera = perturb(Stage.MOUNT, motion(values, "hand_eye")[:, None])
        target = motion(values, "target")[:, None]
        if self.dataset.options == Options("base"):
            return camera, T_base_flange @ target
        return T_base_flange @ camera, target

    def in_camera(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The corners in the camera's frame, (c, m, 3) [m]."""
        T_base_camera, T_base_target = self.frames(values, T_base_flange, perturb)
        T = inverse(T_base_camera) @ T_base_target
        T = np.broadcast_to(T, (len(T), len(self.dataset.poses), 4, 4))
        return apply(T[:, self.dataset.points.pose], perturb(Stage.TARGET, self.dataset.points["xyz"][None]))

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        P = self.in_camera(values, T_base_flange, perturb)
        fx, fy, cx, cy, k1 = (values[name][:, None] for name in INTRINSICS)
        x, y = P[..., 0] / P[..., 2], P[..., 1] / P[..., 2]
        radial = 1.0 + k1 * (x**2 + y**2)
        seen = np.stack([cx + fx * x * radial, cy + fy * y * radial], axis=-1)
        seen[P[..., 2] <= 0.0] = np.nan
        return perturb(Stage.PIXELS, self.dataset.points["pixel"][None]) - seen

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        m = len(self.dataset.points)
        stated = self.dataset.noise.pixel_px
        return [ErrorSource("pixel", along_each_axis(m, 2), np.arange(m), "px", stated=stated)]

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        depth = self.in_camera(values, T_base_flange, perturb)[..., 2:]
        return residuals * depth / np.stack([values["fx"], values["fy"]], axis=-1)[:, None]


TRUTH = {"fx": 900.0, "fy": 905.0, "cx": 640.0, "cy": 360.0, "k1": -0.1}
PIXEL_PX = 0.1


def board_cell(mount: str, *, poses: int = 24, offset: float = 0.0, seed: int = 0) -> tuple[Dataset, dict[str, float]]:
    """A UR5 whose camera sees 12 corners of a board in every pose; the second joint's zero may be off [rad]."""
    rng = np.random.default_rng(seed)
    robot = find_robot("ur5")
    q = np.array([0.0, -1.2, 1.4, -1.8, -1.57, 0.0]) + rng.uniform(-0.35, 0.35, (poses, 6))
    across, down = np.meshgrid(np.arange(4.0), np.arange(3.0))
    corners = 0.03 * np.stack([across, down, np.zeros_like(across)], axis=-1).reshape(-1, 3)
    real = q + offset * np.eye(6)[1]
    T_base_flange = robot.forward(real[None])[0]
    hand_eye = {"x": 0.02, "y": -0.05, "z": 0.04, "w": 0.05, "phi": -0.04, "psi": 0.1}
    middle = T_base_flange.mean(axis=0)[:3, 3]
    if mount == "flange":
        target = {"x": middle[0], "y": middle[1], "z": middle[2] - 0.5, "w": np.pi, "phi": 0.0, "psi": 0.2}
    else:
        hand_eye = {"x": middle[0], "y": middle[1], "z": middle[2] - 0.8, "w": 0.05, "phi": 0.02, "psi": 0.1}
        target = {"x": 0.02, "y": -0.03, "z": 0.05, "w": 0.03, "phi": 0.05, "psi": -0.1}
    truth = TRUTH | {f"hand_eye.{k}": float(v) for k, v in hand_eye.items()}
    truth |= {f"target.{k}": float(v) for k, v in target.items()}
    spans = {name: 0.03 * value for name, value in TRUTH.items()} | {"k1": 0.1}
    unit_of = BoardCamera.format.unit_of
    parameters = {}
    for name, value in truth.items():
        span = abs(spans.get(name, 0.05))
        nominal = value + 0.5 * span * rng.uniform(-1, 1)
        parameters[name] = Parameter(name, unit_of(name), nominal, nominal - span, nominal + span)
    rows = np.repeat(np.arange(poses), len(corners))
    names = tuple(str(i) for i in range(len(corners))) * poses
    blank = Dataset(
        name=f"board-{mount}",
        kind="board_camera",
        robot=robot,
        poses=Poses(tuple(map(str, range(poses))), q=real, time_s=np.arange(poses) * 10.0),
        points=Points(rows, names, pixel=np.zeros((len(rows), 2)), xyz=np.tile(corners, (poses, 1))),
        parameters=parameters,
        options=Options("base" if mount == "base" else "flange"),
        placed=False,
        noise=Noise(pixel_px=PIXEL_PX),
    )
    model = Model(blank)
    seen = -model.residuals(np.array([truth[name] for name in model.parameters.names])[None])[0]
    assert np.isfinite(seen).all()
    points = Points(rows, names, pixel=seen + PIXEL_PX * rng.normal(size=seen.shape), xyz=blank.points.xyz)
    read = Poses(blank.poses.names, q=q, time_s=blank.poses.time_s)
    return replace(blank, points=points, poses=read), truth


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_it_is_saved_loaded_and_calibrated_as_any_other(mount: str, tmp_path: Path) -> None:
    made, truth = board_cell(mount)
    save(made, tmp_path / "cell")
    dataset = robolaser.load(tmp_path / "cell")
    assert dataset.options == made.options
    result = calibrate(dataset)
    entries = as_json(result)
    jsonschema.validate(entries, json.loads(files("robolaser").joinpath("schemas/calibration.schema.json").read_text()))
    (rows,) = entries["rows"]
    assert (rows["sensor"], rows["rows"], rows["unit"]) == ("board_camera", len(dataset.points), "px")
    assert rows["rms"] == pytest.approx(np.sqrt(2) * PIXEL_PX, rel=0.1)
    assert rows["rms"] < rows["held_out_rms"] < 1.5 * rows["rms"]
    assert entries["objective_m2"] is None
    there = result.model.in_metres(result.x, result.unseen.errors)
    assert entries["held_out_rms_m"] == pytest.approx(np.sqrt(np.square(there).sum(axis=1).mean()))
    shown = ErrorAnalysis(result).compared[1]["held out"]
    assert np.sqrt(np.square(shown).sum(axis=1).mean()) == pytest.approx(entries["held_out_rms_m"])
    parameters = entries["parameters"]
    for name, value in truth.items():
        assert parameters[name]["value"] == pytest.approx(value, abs=5 * parameters[name]["std"])
    assert parameters["fx"]["unit"] == "px"
    assert np.sqrt(np.mean(result.residuals**2)) == pytest.approx(PIXEL_PX, rel=0.1)


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_it_is_diagnosed_as_any_other(mount: str) -> None:
    found = examine(board_cell(mount, poses=30, offset=5e-3)[0], seed=0)
    assert found.verdict == "explained"
    assert [str(one.candidate_effect) for one in found.findings] == ["joint_offset at shoulder_lift_joint"]
    assert found.findings[0].parameters["offset"].value == pytest.approx(5e-3, rel=0.1)


def test_without_a_cause_it_has_no_gap() -> None:
    found = examine(board_cell("flange")[0], seed=0)
    assert found.verdict == "no_gap"
    assert found.gap.after_m == pytest.approx(found.gap.noise_floor_m, rel=0.15)


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_its_derivatives_are_those_of_differences_though_it_wrote_none(mount: str) -> None:
    dataset, _ = board_cell(mount)
    model = Model(dataset, candidate_effects(["joint_offset:shoulder_lift_joint"], dataset))
    x, width = model.parameters.nominal, model.parameters.width
    ahead, behind = (model.residuals(x + way * np.diag(1e-5 * width)) for way in (1, -1))
    expected = (ahead - behind) / 2e-5
    found = jacobian(model, x[None])[0] * width[:, None, None]
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7 * np.abs(expected).max())
