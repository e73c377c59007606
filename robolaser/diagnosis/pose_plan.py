"""Prediction of detectable effects and their sizes from planned poses, before a measurement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.sensor_format import Mount
from robolaser.diagnosis.detection_limits import correlations, detection_limits
from robolaser.diagnosis.findings import not_testable
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.noise_remarks import KEYS
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.result import DetectionLimit
from robolaser.diagnosis.score_tests import library, typical_tests
from robolaser.errors import DataError, EstimationError
from robolaser.estimation.outliers import MIN_POSES
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.simulation.planned import planned


@final
@dataclass(frozen=True)
class PosePlan:
    """Effects that planned poses can detect and distinguish."""

    dataset: Dataset  # the poses with their expected measurements
    seeing: int  # number of poses with points
    noise: NoiseModel
    silent: tuple[str, ...]  # sources of error without a stated size, assumed to be zero
    limits: tuple[DetectionLimit, ...]  # smallest detectable size, and identifiable size beside the nearest rival
    candidates: tuple[CandidateEffect, ...]  # effects at their locations, in the order of `alike`
    alike: Array  # |cosine| of two effects' columns beside the sensor's parameters, (e, e); 1: not distinguishable here
    untestable: Mapping[str, str]  # why an effect could not be tested, by its name

    def to_dict(self) -> dict[str, Any]:
        """Contents of the output of `--json`, format `robolaser-plan/1`."""
        return {
            "format": "robolaser-plan/1",
            "dataset": self.dataset.name,
            "sensor": self.dataset.kind,
            "poses": len(self.dataset.poses),
            "poses_with_points": self.seeing,
            "noise": {name: sigma for name, sigma in self.noise.sigmas.items() if sigma > 0.0},
            "effects": [
                {
                    "effect": limit.candidate_effect.effect.name,
                    "where": limit.candidate_effect.where,
                    "parameter": limit.parameter,
                    "unit": limit.unit,
                    "detectable": limit.size,
                    "identifiable": limit.identifiable,
                    "at_tool_mm": None if limit.at_tool_m is None else 1e3 * limit.at_tool_m,
                    "nearest": None
                    if limit.rival is None
                    else {"effect": limit.rival.effect.name, "where": limit.rival.where},
                }
                for limit in self.limits
            ],
            "candidates": [[one.effect.name, one.where] for one in self.candidates],
            "correlation": self.alike.round(4).tolist(),
            "not_testable": [{"effect": name, "reason": reason} for name, reason in self.untestable.items()],
        }


def examine_plan(
    dataset: Dataset,
    effects: Sequence[type[Effect]] | None = None,
    *,
    points: int | None = None,
    mount: Mount = "flange",
    seed: int = 0,
) -> PosePlan:
    """Determine detectable and distinguishable effects from the Fisher information of planned poses.

    Args:
        dataset: The poses of a robot, the kind of sensor and the expected noise. Measured points, if any, are used with
            their noise; else a sensor of that kind is simulated.
        effects: The library of effects.
        points: Number of simulated points in each pose.
        mount: Mount of a simulated camera.
        seed: Seed of the simulated sensor.

    Raises:
        DataError: There are no joint readings, or no noise is stated.
        EstimationError: Too few poses see the target.
    """
    if dataset.robot is None or dataset.poses.q is None:
        raise DataError("A plan needs an arm and its joint angles: flange poses do not determine its joint motions.")
    with threadpool_limits(limits=1, user_api="blas"):
        fit, silent = _measured(dataset, seed) if len(dataset.points) else _simulated(dataset, points, mount, seed)
        seen, kinds = fit.model.dataset, list(EFFECTS if effects is None else effects)
        tests = typical_tests(fit, library(kinds, seen))
        limits = detection_limits(tests)
        return PosePlan(
            dataset=seen,
            seeing=len(fit.poses),
            noise=fit.noise,
            silent=silent,
            limits=limits,
            candidates=tuple(test.candidate_effect for test in tests),
            alike=correlations(tests),
            untestable=not_testable(kinds, seen, limits, enough=True),
        )


def _measured(dataset: Dataset, seed: int) -> tuple[Fit, tuple[str, ...]]:
    """The model fitted to measured points."""
    _enough(len(np.unique(dataset.points.pose)), dataset)
    return Preparation.of(dataset, seed).fit([]), ()


def _simulated(dataset: Dataset, points: int | None, mount: Mount, seed: int) -> tuple[Fit, tuple[str, ...]]:
    """The model at a simulated sensor's true parameters; and sources of error without a stated size."""
    run = planned(dataset, points=points, mount=mount, seed=seed)
    _enough(run.seeing, dataset)
    model = Model(run.dataset)
    x = np.array([run.truth.get(item.name, item.nominal) for item in model.parameters.items])
    sources = error_sources(model, x)
    sigmas = {source.name: source.stated or 0.0 for source in sources}
    if not any(sigmas.values()):
        rows = " or ".join(f"--{key.replace('_', '-')}" for name, key in KEYS.items() if name in sigmas)
        raise DataError(
            f"No noise is stated, and without it any effect would be detectable. State the expected noise: {rows}, or"
            " [noise] in dataset.toml."
        )
    silent = tuple(source.name for source in sources if source.name == "joint" and source.stated is None)
    return Fit(problem_of(model, NoiseModel(sources, sigmas), model.parameters), x), silent


def _enough(seeing: int, dataset: Dataset) -> None:
    if seeing < MIN_POSES:
        raise EstimationError(
            f"Only {seeing} of {len(dataset.poses)} poses have visible points: at least {MIN_POSES} are needed."
        )
