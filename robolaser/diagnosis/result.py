"""The result of a diagnosis: verdict, gap step by step, locations, effects, and next poses."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.further_poses import Weighed
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.pose_scatter import PartScatter
from robolaser.estimation.certainty import EVEN
from robolaser.estimation.folds import FoldFits
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import Origin
from robolaser.robot.kinematics import Robot


@final
@dataclass(frozen=True)
class Estimate:
    """A parameter of an effect."""

    value: float  # in its unit
    std: float | None  # one standard deviation; None if the data do not determine the value, or it is on a bound
    unit: str  # SI
    bound: str = ""  # `lower` or `upper` where the value ended on that bound, else empty


@final
@dataclass(frozen=True)
class Alternative:
    """An effect that is indistinguishable at these poses from one that was found."""

    candidate_effect: CandidateEffect
    parameters: Mapping[str, Estimate]  # its parameters by name, fitted instead of those of the effect found
    gap_m: float  # held-out gap with it instead of the effect found


@final
@dataclass(frozen=True)
class Finding:
    """An effect that was found."""

    candidate_effect: CandidateEffect
    probability: float  # its probability at this location, against every other candidate, none, and an unknown cause
    parameters: Mapping[str, Estimate]  # its parameters by name
    gap_before_m: float  # held-out gap with the preceding findings in the model
    gap_after_m: float  # held-out gap with this one, too
    gap_without_m: float  # held-out gap with all findings but this one
    alternatives: tuple[Alternative, ...]  # the nearest first


@final
@dataclass(frozen=True)
class CauseKind:
    """An effect at all of its likely locations."""

    effect: str  # its name
    where: tuple[str, ...]
    probability: float  # probability that it is present at any location
    gap_without_m: float  # held-out gap of the final model without it [m]


@final
@dataclass(frozen=True)
class CauseClass:
    """A class of causes."""

    name: str
    probability: float  # probability that at least one of its members is present
    gap_without_m: float | None  # held-out gap without its members [m]; None if the model has none of them
    gap_with_m: float  # held-out gap of the final model [m]
    members: tuple[tuple[CandidateEffect, float], ...] = ()  # with their probabilities, the most probable first
    # for each of its effects found, the smallest set of candidates of any class that contains the true one with
    # 95 % probability, if there is such a set
    credible_sets: tuple[tuple[CandidateEffect, ...], ...] = ()
    site: str = ""  # site of an unknown cause


@final
@dataclass(frozen=True)
class WrongInput:
    """A fault of the data set rather than of the cell, to be corrected in the files."""

    name: str  # `mispaired` or `held_parameter`
    where: str  # the sensor's part
    cause: str  # its class of causes
    probability: float
    parameters: Mapping[str, Estimate]  # by name; of those that the data set holds, the values of a free fit
    gap_before_m: float  # held-out gap with the fault
    gap_after_m: float  # held-out gap after its correction
    alternatives: tuple[CandidateEffect, ...] = ()  # effects that may be the cause instead


@final
@dataclass(frozen=True)
class RotationGap:
    """Root-mean-square error of rotations on held-out poses [rad]."""

    calibrated_rad: float  # with the fitted parameters, without effects
    after_rad: float  # with all effects found
    least_rad: float  # lower end of its 95 % interval
    noise_floor_rad: float  # by noise alone


@final
@dataclass(frozen=True)
class Gap:
    """Root-mean-square 3-D error on held-out poses, repeats averaged, gross errors excluded [m]."""

    nominal_m: float | None  # error of the nominal model; None if none is given
    calibrated_m: float
    after_m: float
    noise_floor_m: float
    after_ci95_m: tuple[float, float]
    rotations: RotationGap | None = None  # error of rotations; None if none are measured
    is_held_out: bool = True  # whether any pose was held out; else all errors are of fitted poses
    distances_m: tuple[float, float] | None = None  # of known distances, calibrated and after; None without any


@final
@dataclass(frozen=True)
class NoiseSource:
    """The size of a source of noise."""

    value: float  # standard deviation
    unit: str
    origin: Origin
    of_poses: bool  # whether it moves whole poses


@final
@dataclass(frozen=True)
class Repeatability:
    """The scatter of whole poses."""

    sources: Mapping[str, NoiseSource]  # its sources by name: joint readings, flange poses, a tracker's probe
    at_sensor_m: float  # resulting root-mean-square 3-D error of a row [m]
    is_stated: bool = False  # whether the data set states the arm's repeatability

    def is_most_of(self, floor_m: float) -> bool:
        """Whether it is reported: it is not stated, and is most of a row's noise.

        Without scatter of poses, chance makes a third of the noise look like it.
        """
        is_estimated = any(source.origin != "stated" for source in self.sources.values())
        return is_estimated and self.at_sensor_m > EVEN * floor_m


@final
@dataclass(frozen=True)
class DetectionLimit:
    """The smallest size of an effect's principal parameter that is detected nine times in ten in these data."""

    candidate_effect: CandidateEffect
    parameter: str  # name of its principal parameter
    size: float | None  # detectable size in its unit; None if no plausible size is detected
    unit: str  # SI
    identifiable: float | None = None  # smallest size that tells it from its nearest rival, if any plausible one does
    rival: CandidateEffect | None = None  # the most similar candidate of no higher complexity penalty; None without one
    at_tool_m: float | None = None  # RMS displacement of these measurements by the detectable size, without a refit [m]
    is_imitated: bool = False  # whether it is undetectable only because the effects found imitate it


@final
@dataclass(frozen=True)
class Validation:
    """Prediction of other data of the same arm; only placements and mounts of the campaign are refitted.

    Errors are root-mean-square 3-D errors on poses held out from that fit, gross errors excluded [m].
    """

    dataset: str  # name of the other data set
    nominal_m: float | None  # with the nominal arm and sensor; None without a nominal model
    calibrated_m: float  # with the calibrated parameters, without effects
    after_m: float  # with all effects found, as far as they transfer
    noise_floor_m: float  # by noise alone
    is_better: bool  # whether the effects significantly lower the error, poses being independent
    rows: int  # number of compared rows, repeats averaged
    remarks: tuple[str, ...]  # effects that do not transfer unchanged, and excluded rows


@final
@dataclass(frozen=True)
class Diagnosis:
    """The result of a diagnosis.

    Attributes:
        dataset: The data set, without a fault that was found in it.
        verdict: `no_gap`, `explained` or `unexplained`.
        sentence: The verdict in sentences.
        gap: The gap without and with effects.
        where: Locations of the gap; for `unexplained`, of the remaining error.
        findings: Effects found, that with the largest gap without it first; effects of the model that are too
            improbable by themselves are omitted.
        kinds: Effects with all of their locations, those that explain most first.
        classes: Possible classes of causes, most important first.
        outliers: Gross errors, as rows of points.csv (from 0).
        not_testable: Why an effect could not be tested, by its name.
        next_poses: Joint values by name of poses that distinguish the leading rivals.
        limits: Detection limits of effects that were not found.
        model: The final model, on averaged rows.
        x: Its parameters, in the order of `model.parameters`.
        std: One standard deviation of each; NaN for fixed ones.
        calibrated_x: The sensor's parameters without effects in the model, in the same order.
        unseen: Fits of the final model without each fold of these rows; None if none could be held out.
        before_m: Held-out errors of the averaged rows in the calibrated model, (m, 3).
        after_m: Held-out errors of the averaged rows with all effects, (m, 3).
        noise: Sources of noise, by name.
        repeatability: Scatter of whole poses.
        odd_rows: Part of the sentence on rows that disagree with the others; may be empty.
        noise_remarks: Remarks on contradictions of the stated noise.
        seconds: Time taken.
        validation: Predictions of other data of the same arm.
        hindrance: Why no effect was searched for, as a sentence; empty otherwise.
        wrong_input: A fault of the data set; None without one.
        pose_scatter: Excess scatter of whole poses beyond noise; None without it.
        weighed: The models that were weighed, for charts and for further poses.
        as_given: The data set with its fault; None if `dataset` is the given one.
        added_poses: Number of further poses that count only in probabilities and sizes.
        belongs: For each exchanged pose, the one where its rows belong, and count.

    Examples:
        >>> from robolaser.diagnosis import examine
        >>> examine(dataset, effects=[]).gap.nominal_m > 0
        True
    """

    dataset: Dataset
    verdict: str
    sentence: str
    gap: Gap
    where: tuple[Localization, ...]
    findings: tuple[Finding, ...]
    kinds: tuple[CauseKind, ...]
    classes: tuple[CauseClass, ...]
    outliers: Ints
    not_testable: Mapping[str, str]
    next_poses: tuple[Mapping[str, float], ...]
    limits: tuple[DetectionLimit, ...]
    model: Model
    x: Array
    std: Array
    calibrated_x: Array
    unseen: FoldFits | None
    before_m: Array
    after_m: Array
    noise: Mapping[str, NoiseSource]
    repeatability: Repeatability
    noise_remarks: tuple[str, ...]
    seconds: float
    weighed: Weighed
    odd_rows: str = ""
    validation: tuple[Validation, ...] = ()
    hindrance: str = ""
    wrong_input: WrongInput | None = None
    pose_scatter: PartScatter | None = None
    as_given: Dataset | None = None
    added_poses: int = 0
    belongs: Mapping[int, int] = field(default_factory=dict)

    @property
    def observed(self) -> Dataset:
        """Averaged rows without gross errors."""
        return self.model.dataset

    @cached_property
    def robot(self) -> Robot | None:
        """The corrected arm, as the exported URDF has it: `forward`, `jacobian` and `inverse`, in batches.

        With the offsets and placements of joints in the model, but without what a URDF cannot hold, such as compliance.
        None for a data set of measured flange poses.
        """
        return self.model.robot_at(self.x)

    @property
    def poses(self) -> tuple[int, int]:
        """Number of poses used, and number of poses with points."""
        used, every = (len(np.unique(one.points.pose)) for one in (self.observed, self.dataset))
        return used + self.added_poses, every
