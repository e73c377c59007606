"""Check of a data set before any fit: whether it can be calibrated, testable effects, and data missing for the rest."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from robolaser.calibration.checks import check_poses, check_target
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import MAX_ROWS, subsampled
from robolaser.diagnosis.score_tests import lack_of_poses
from robolaser.diagnosis.thresholds import SMALL_SHARE
from robolaser.errors import RobolaserError
from robolaser.estimation.identifiability import null_directions
from robolaser.estimation.outliers import MIN_POSES
from robolaser.estimation.problem import Problem
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import Effect
from robolaser.model.effects.requirements import DataLack
from robolaser.model.forward_model import Model, jacobian_matrix


@final
@dataclass(frozen=True)
class Testability:
    """Whether an effect can be tested."""

    effect: str  # its name
    locations: tuple[str, ...]  # its possible locations; empty if it cannot be tested
    reason: str = ""  # why it cannot be tested; "" if it can
    remedy: str = ""  # data to record or state; "" if nothing helps with this kind of sensor


@final
@dataclass(frozen=True)
class DataCheck:
    """Analyses that a data set permits."""

    dataset: Dataset
    hindrance: str  # why it cannot be calibrated; "" if it can
    parameters: tuple[str, ...]  # names of the calibration's parameters
    inseparable: tuple[tuple[str, ...], ...]  # groups of them that these data cannot separate near the start values
    effects: tuple[Testability, ...]  # testability of every effect
    missing: Mapping[str, tuple[str, ...]]  # data to record or state, and the effects that need them

    def to_dict(self) -> dict[str, Any]:
        """As JSON."""
        points, poses = self.dataset.points, self.dataset.poses
        return {
            "dataset": self.dataset.name,
            "sensor": self.dataset.kind,
            "poses": len(poses),
            "poses_with_points": len(np.unique(points.pose)),
            "points": len(points),
            "calibration": {
                "possible": not self.hindrance,
                "reason": self.hindrance or None,
                "parameters": list(self.parameters),
                "inseparable": [list(names) for names in self.inseparable],
            },
            "effects": [
                {
                    "effect": one.effect,
                    "testable": not one.reason,
                    "locations": list(one.locations),
                    "reason": one.reason or None,
                }
                for one in self.effects
            ],
            "missing": [{"add": remedy, "for": list(names)} for remedy, names in self.missing.items()],
            "warnings": list(self.dataset.warnings),
        }


def check_data(dataset: Dataset) -> DataCheck:
    """Check a data set without any fit, within a second."""
    hindrance, parameters, inseparable = _calibration(dataset)
    images = sum(map(bool, dataset.poses.image or ()))
    poses = len(np.unique(dataset.points.pose)) if len(dataset.points) else images
    tested = tuple(_testability(kind, dataset, poses) for kind in EFFECTS)
    missing: dict[str, tuple[str, ...]] = {}
    for one in tested:
        if one.remedy:
            missing[one.remedy] = (*missing.get(one.remedy, ()), one.effect)
    if dataset.points.repeat is None and not any(vars(dataset.noise).values()):
        repeats = "shots repeated at unmoved poses (column repeat), or known noise ([noise])"
        missing[repeats] = ("noise_floor",)
    return DataCheck(dataset, hindrance, parameters, inseparable, tested, missing)


def _testability(kind: type[Effect], dataset: Dataset, poses: int) -> Testability:
    reason = kind.missing(dataset)
    if not reason and poses < MIN_POSES:
        return Testability(
            kind.name, (), f"fewer than {MIN_POSES} poses have points", f"at least {MIN_POSES} poses with points"
        )
    locations = kind.locations(dataset)
    if not reason and len(dataset.points) and (lack := lack_of_poses(kind, dataset)):
        reason, locations = lack, ()
    if not reason and not locations:
        reason = "undetectable at every joint in these poses"
    return Testability(kind.name, locations, reason, reason.remedy if isinstance(reason, DataLack) else "")


def _calibration(dataset: Dataset) -> tuple[str, tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Why it cannot be calibrated, the parameters, and groups that cannot be separated.

    Parameters are checked at random values near their start values, which are often special (a right angle, a lens
    without distortion), so that less is identifiable there than at the true values.
    """
    if not len(dataset.points):
        if dataset.poses.image is not None:
            return "There are no points yet: `robolaser extract` finds them in the images.", (), ()
        return "There are no points: points.csv must have the measurements of each pose.", (), ()
    try:
        model = Model(subsampled(dataset, MAX_ROWS), ()).sharing(Model(dataset).sensor_parameters)
        problem = Problem.of(model)
        check_target(model)
        check_poses(problem)
    except RobolaserError as error:
        return str(error), (), ()
    free = np.flatnonzero(~problem.fixed)
    names = np.array(model.parameters.names)
    draw = np.random.default_rng(0).uniform(-SMALL_SHARE, SMALL_SHARE, len(names))
    aside = model.parameters.nominal + np.where(problem.fixed, 0.0, draw * model.parameters.width)
    J = np.nan_to_num(jacobian_matrix(model, np.clip(aside, model.parameters.lower, model.parameters.upper)))[:, free]
    moved = (J != 0.0).any(axis=0)  # a column of zeros: the parameter moves no row
    groups = [tuple(names[free[moved]][direction != 0.0].tolist()) for direction in null_directions(J[:, moved])]
    groups += [(name,) for name in names[free[~moved]].tolist()]
    return "", tuple(names.tolist()), tuple(groups)
