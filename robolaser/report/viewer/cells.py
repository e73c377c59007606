"""The displayed cell of a data set: by its nominal values, or by the numbers of a calibration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points
from robolaser.errors import DataError
from robolaser.model.effects.effect import CandidateEffect, CarryOver, Run
from robolaser.model.effects.run import RunSummary, continued
from robolaser.model.forward_model import Model
from robolaser.model.sensors import sensor_class
from robolaser.model.sensors.stripe import SCANNER
from robolaser.parameters import Parameter, as_batch
from robolaser.report.cell_poses import LIGHT_POINTS, NOTHING, CellFrames, CellPoses


@final
@dataclass(frozen=True)
class ArmAlone:
    """An arm whose sensor was not calibrated, and is not drawn."""

    dataset: Dataset
    name: ClassVar[str] = "nominal"
    groups: ClassVar[tuple[str, ...]] = ()
    target: ClassVar[Array] = NOTHING
    points: ClassVar[Array] = NOTHING

    def at_pose(self, number: int) -> CellFrames:
        """The arm at a pose of the data set."""
        q = self.dataset.poses.q
        return CellFrames(np.empty((0, 4, 4)), self.dataset.flange()[number]) if q is None else self.at(q[number])

    def at(self, q: Array) -> CellFrames:
        """The arm at other joint angles, (j,) [rad or m]."""
        robot, _ = self.dataset.arm
        return CellFrames(robot.joint_frames(q), robot.forward(q))


def fitted_cell(
    dataset: Dataset, effects: Sequence[CandidateEffect], numbers: Mapping[str, float], found_in: RunSummary | None
) -> tuple[CellPoses, Sequence[str]]:
    """The cell of a data set by the numbers of a calibration, by name; and caveats on its effects there.

    The data set is the calibrated run, or a recording of the same cell; `found_in` is None where the run is unknown.

    Raises:
        DataError: The calibration lacks a number that the data set's model has: it is of another cell.
    """
    run = Run(dataset) if found_in == RunSummary.of(dataset) else continued(found_in, dataset)
    found = {name: numbers[name] for name in SCANNER if name in numbers}
    scanner = {name: Parameter(name, "", value, value, value) for name, value in found.items()}
    described = replace(_with_stripes(dataset), parameters={**scanner, **dataset.parameters})
    model = Model(described, tuple(effects), run.course)
    if missing := [name for name in model.parameters.names if name not in numbers]:
        raise DataError(
            f"The calibration has no {', '.join(missing[:4])}, which {dataset.name} needs: it is of another cell, or of"
            " other sessions. Name the calibration of this data set.",
            file="calibration.json",
        )
    acting, here, doubts = [], dict(numbers), []
    for one in effects:
        carried = CarryOver.of(one.at(as_batch(numbers)), run, found_in)
        if carried.effect is None:
            doubts.append(f"{one} is left out: {carried.doubt}.")
            continue
        acting.append(one)
        here |= {one.key(name): float(getattr(carried.effect, name)[0]) for name in one.effect.units()}
        if carried.doubt:
            doubts.append(f"{one}: {carried.doubt}{', points may be off' if carried.alternatives else ''}.")
    model = model.with_effects(tuple(acting))
    x = np.array([here[name] for name in model.parameters.names])
    return CellPoses(model, x, is_measured=len(dataset.points) > 0), doubts


def nominal_cell(dataset: Dataset) -> CellPoses | ArmAlone:
    """The cell by the nominal values of dataset.toml; of a sensor without a laser plane the arm alone.

    Raises:
        DataError: A stripe scanner lacks one of its fourteen parameters.
    """
    if not sensor_class(dataset.kind).has_laser_plane():
        return ArmAlone(dataset)
    if missing := [name for name in SCANNER if name not in dataset.parameters]:
        raise DataError(
            f"dataset.toml, [parameters] lacks {', '.join(missing)}: a {dataset.kind} sensor needs "
            "{ nominal, lower, upper } for each. Or name a calibration beside it:"
            " `robolaser view DATASET CALIBRATION`.",
            file="dataset.toml",
            column="parameters",
        )
    model = Model(_with_stripes(dataset))
    return CellPoses(model, model.parameters.nominal, "nominal", len(dataset.points) > 0)


def _with_stripes(dataset: Dataset) -> Dataset:
    """The same with pixels in the middle of the image along the stripe, if a scanner has no points yet."""
    if len(dataset.points) or not sensor_class(dataset.kind).has_laser_plane():
        return dataset
    size, along = np.array(dataset.image_px or (1, 1)), 0 if dataset.stripe_axis == "u" else 1
    pixel = np.tile((size - 1.0) / 2.0, (LIGHT_POINTS, 1))
    pixel[:, along] = np.linspace(0.0, size[along] - 1.0, LIGHT_POINTS)
    n = len(dataset.poses)
    names = tuple(f"{i}" for i in range(LIGHT_POINTS)) * n
    where, xyz = np.arange(n).repeat(LIGHT_POINTS), np.zeros((n * LIGHT_POINTS, 3))
    return replace(dataset, placed=True, points=Points(where, names, pixel=np.tile(pixel, (n, 1)), xyz=xyz))
