"""What a calibration's page and charts are about: errors in millimetres, and what noise alone would make of them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import some_of_each
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel, pixel_from_repeats
from robolaser.model.noise.sources import error_sources
from robolaser.model.pose_blocks import depends_on_trajectory, with_rows
from robolaser.model.sensors.sensor import vector
from robolaser.model.sensors.stripe import Stripe
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values
from robolaser.report.chart import Spec, records

ENOUGH_ROWS = 20_000
"""Rows that tell a root mean square to three digits."""


def known_noise(dataset: Dataset) -> dict[str, str]:
    """Sources of noise whose size does not come from the residuals themselves, and where it comes from."""
    stated = {
        "pixel": dataset.noise.pixel_px,
        "target": dataset.noise.target_m,
        "joint": dataset.noise.joint_rad,
        "point": dataset.noise.point_m,
    }
    known = {name: "stated in the data set" for name, sigma in stated.items() if sigma is not None}
    if "pixel" not in known and pixel_from_repeats(dataset) is not None:
        known["pixel"] = "from repeats"
    return known


@final
@dataclass(frozen=True)
class Evidence:
    """A calibration with what follows from it."""

    calibration: Calibration

    @cached_property
    def values(self) -> Values:
        """The parameters found, (1,) each."""
        return self.calibration.model.parameters.values(self.calibration.x[None])

    @cached_property
    def perturb(self) -> Perturbation:
        """The effects in the model."""
        return self.calibration.model.perturb(self.values)

    @cached_property
    def fitted_mm(self) -> Array:
        """Length of each residual, (m,) [mm]."""
        return lengths_mm(self.calibration.residuals)

    @cached_property
    def held_out_mm(self) -> Array | None:
        """The same on poses left out of the fit."""
        held_out = self.calibration.held_out
        return None if held_out is None else lengths_mm(held_out)

    @cached_property
    def known_noise(self) -> dict[str, str]:
        """See the function of this name; only sources that this data set has."""
        return {name: origin for name, origin in known_noise(self.calibration.model.dataset).items()
                if name in self.calibration.noise}  # fmt: skip

    @cached_property
    def noise(self) -> NoiseModel | None:
        """The noise that is known without looking at the residuals, of no more rows than a figure needs; or None."""
        if not self.known_noise:
            return None
        calibration = self.calibration
        some = _thinned(calibration.model)
        sources = error_sources(some, calibration.x)
        sigmas = {s.name: calibration.noise[s.name] if s.name in self.known_noise else 0.0 for s in sources}
        return NoiseModel(sources, sigmas)

    @cached_property
    def noise_m(self) -> float | None:
        """Root-mean-square 3-D error that this noise alone would give [m]."""
        if self.noise is None:
            return None
        return float(np.sqrt(np.trace(self.noise.covariances, axis1=1, axis2=2).mean()))

    @cached_property
    def known(self) -> Array:
        """Where points are known or were measured to be, (m, 3) [m]: base frame, or the tracker's."""
        return known_points(self.calibration.model, self.values, self.perturb)

    def named(self, rows: Ints, **columns: Any) -> list[Spec]:
        """Records of some rows of points.csv for a chart, with the names of their poses and points."""
        pose, point = point_names(self.calibration.model.dataset, rows)
        return records(pose=pose, point=point, **columns)

    def per_pose(self, errors: Array) -> tuple[Ints, Array]:
        """Numbers of the poses with points, and the root-mean-square error in each [mm]."""
        pose = self.calibration.model.dataset.points.pose
        seen, counts = np.unique(pose, return_counts=True)
        squares = np.bincount(pose, (errors**2).sum(axis=-1))[seen]
        return seen, 1e3 * np.sqrt(squares / counts)


def _thinned(model: Model) -> Model:
    """Some rows of each pose, where there are more than a figure needs."""
    if len(model.dataset.points) <= ENOUGH_ROWS or depends_on_trajectory(model):
        return model
    some = some_of_each(model.dataset.points.pose, max(1, ENOUGH_ROWS // len(model.dataset.poses)))
    return with_rows(model, np.sort(some[some >= 0]))


def known_points(model: Model, values: Values, perturb: Perturbation) -> Array:
    """Where points are known or were measured to be, (m, 3) [m]: base frame, or the tracker's."""
    points = model.dataset.points
    if isinstance(model.sensor, Stripe):
        known: Array = model.sensor.target(values, perturb)[0]
        return known
    if points.xyz is not None:
        measured: Array = perturb(Stage.TARGET, points.xyz[None])[0]
        return measured
    sockets = np.stack([vector(values, f"socket.{name}")[0] for name in dict.fromkeys(points.names)])
    return sockets[points.number]


def lengths_mm(errors: Array) -> Array:
    """Lengths of errors (m, 3) [m], (m,) [mm]."""
    lengths: Array = 1e3 * np.linalg.norm(errors, axis=-1)
    return lengths


def point_names(dataset: Dataset, rows: Ints) -> tuple[list[str], list[str]]:
    """Names of the poses and of the points of some rows of points.csv."""
    points, poses = dataset.points, dataset.poses
    return [poses.names[points.pose[i]] for i in rows], [points.names[i] for i in rows]


def some_rows(errors: Array, most: int) -> Ints:
    """At most `most` rows for a chart: evenly thinned, the largest tenth of them always among them."""
    if len(errors) <= most:
        return np.arange(len(errors))
    even = np.linspace(0, len(errors) - 1, most - most // 10).round().astype(int)
    largest = np.argsort(errors)[-(most // 10) :]
    return np.unique(np.concatenate([even, largest])).astype(np.int64)
